"""The cheapest walk through a transition graph that passes goals in order, each within its time, at its place.

A dynamic programme over time, step by step, over the states (stage, frame): one best walk is kept for each. Bellman's
costs to go, which forget times and places, are exact lower bounds of what is left; with them the beam is A*'s, and
the search ends as soon as no open walk can beat the best finished one. Without places and warps, and with a beam as
wide as there are states, it is exact.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import ComplexArray, FloatArray, IntArray
from kinetograph.learn.goals import Goal, SearchOptions, Stay, Walk, costs_to_go, least_steps, longest_legs
from kinetograph.learn.transitions import Graph


@dataclass(frozen=True, eq=False)
class _Labels:
    """Open walks. begun, clock: step and warped step of the stage's start; turn, shift: from a recording's ground to
    the world's.
    """

    stage: IntArray
    frame: IntArray
    cost: FloatArray
    node: IntArray
    begun: IntArray
    clock: FloatArray
    turn: ComplexArray
    shift: ComplexArray

    def __len__(self) -> int:
        return len(self.frame)

    def pick(self, index: object) -> _Labels:
        return _Labels(*(value[index] for value in vars(self).values()))

    def with_values(self, **changes: object) -> _Labels:
        return _Labels(**{**vars(self), **changes})


def _join(labels: list[_Labels]) -> _Labels:
    return _Labels(*(np.concatenate(columns) for columns in zip(*(vars(x).values() for x in labels), strict=True)))


@dataclass(eq=False)
class _Nodes:
    """The tree of walks: parent, and the stay that begins at a node."""

    rows: list[IntArray] = field(default_factory=list)
    count: int = 0

    def add(self, parent: IntArray, frame: IntArray, step: int, stage: IntArray, edge: IntArray) -> IntArray:
        block = np.stack([parent, frame, np.full(len(parent), step), stage, edge], axis=1)
        self.rows.append(block)
        self.count += len(block)
        return np.arange(self.count - len(block), self.count)

    def trace(self, node: int) -> tuple[Stay, ...]:
        table = np.concatenate(self.rows)
        stays = []
        while node >= 0:
            parent, frame, step, stage, edge = (int(v) for v in table[node])
            stays.append(Stay(frame, step, stage, edge))
            node = parent
        return tuple(reversed(stays))


class _Search:
    """One search: the open walks by the step at which they may go on, and the best finished one."""

    def __init__(
        self, graph: Graph, goals: list[Goal], ground: ComplexArray, facing: ComplexArray, options: SearchOptions
    ) -> None:
        self.graph, self.goals, self.ground, self.facing, self.options = graph, goals, ground, facing, options
        legs = longest_legs(goals, options)
        self.to_go = np.stack(costs_to_go(graph, goals[1:], legs, options.step_fee))
        self.steps = np.stack([least_steps(graph, goal, leg) for goal, leg in zip(goals[1:], legs, strict=True)])
        self.reward = np.full((len(goals) - 1, len(graph)), np.inf)
        for stage, goal in enumerate(goals[1:]):
            np.minimum.at(self.reward[stage], goal.frames, goal.costs)
        self.waiting: dict[int, list[_Labels]] = {}
        self.nodes = _Nodes()
        self.best: tuple[float, int, int, float] | None = None

    def run(self) -> Walk | None:
        step = 0
        self._begin()
        while self.waiting:
            step = min(self.waiting)
            open_ = self._prune(_join(self.waiting.pop(step)), step)
            if len(open_) == 0:
                continue
            self._pass_goals(open_, step)
            self._play(open_, step)
            self._jump(open_, step)
        return self._finish()

    def _begin(self) -> None:
        goal = self.goals[0]
        turn = np.ones(len(goal.frames), dtype=np.complex128)
        if goal.heading is not None:
            turn = np.exp(1j * goal.heading) / self.facing[goal.frames]
        shift = (goal.place or 0j) - turn * self.ground[goal.frames]
        zeros = np.zeros(len(goal.frames), dtype=np.int64)
        node = self.nodes.add(zeros - 1, goal.frames, 0, zeros, zeros - 1)
        labels = _Labels(zeros, goal.frames, goal.costs, node, zeros, zeros.astype(np.float64), turn, shift)
        self._commit(labels, self.graph.commit)

    def _commit(self, labels: _Labels, step: int) -> None:
        """Let walks play on for the least number of frames, until ``step``; those whose recording ends before go."""
        labels = labels.with_values(frame=labels.frame + self.graph.commit)
        self._wait(labels.pick(labels.frame <= self.graph.last[labels.frame - self.graph.commit]), step)

    def _wait(self, labels: _Labels, step: int) -> None:
        if len(labels):
            self.waiting.setdefault(step, []).append(labels)

    def _bound(self, labels: _Labels, step: int) -> FloatArray:
        """What a walk costs at least once it is finished; infinite where its goal cannot be met in time."""
        bound = labels.cost + self.to_go[labels.stage, labels.frame]
        allowed = self._longest_leg(labels)
        left = allowed - (step - labels.begun)
        bound = np.where(self.steps[labels.stage, labels.frame] <= left, bound, np.inf)
        for stage, goal in enumerate(self.goals[1:]):
            if goal.place is not None and np.isfinite(self.options.speed):
                here = labels.turn * self.ground[labels.frame] + labels.shift
                short = np.maximum(np.abs(goal.place - here) - self.options.speed * np.maximum(left, 0), 0.0)
                extra = np.where(short > goal.reach, np.inf, (short / self.options.place_scale) ** 2)
                bound = np.where(labels.stage == stage, bound + extra, bound)
        return np.asarray(bound)

    def _longest_leg(self, labels: _Labels) -> FloatArray:
        latest = np.array([goal.window[1] for goal in self.goals[1:]])[labels.stage]
        return np.minimum((latest - labels.clock) * (1 + self.options.warp), self.options.longest)

    def _prune(self, labels: _Labels, step: int) -> _Labels:
        bound = self._bound(labels, step)
        ceiling = self.best[0] if self.best else np.inf
        keep = np.flatnonzero(bound < ceiling)
        if len(keep) > 4 * self.options.beam:  # more are never kept; of one state there are seldom four
            keep = keep[np.argpartition(bound[keep], 4 * self.options.beam)[: 4 * self.options.beam]]
        keep = keep[np.argsort(bound[keep], kind="stable")]
        state = labels.stage[keep] * len(self.graph) + labels.frame[keep]
        if any(goal.place is not None for goal in self.goals[1:]):
            state = state * 4096 + self._cells(labels.pick(keep))
        _, first = np.unique(state, return_index=True)
        return labels.pick(keep[np.sort(first)][: self.options.beam])

    def _cells(self, labels: _Labels) -> IntArray:
        """Which of 16 x 16 x 16 places and headings, repeating, a walk is at: those that differ there stay apart."""
        here = labels.turn * self.ground[labels.frame] + labels.shift
        side = 2 * self.options.place_scale
        heading = np.angle(labels.turn) // (2 * np.pi / 16)
        return np.asarray(
            ((here.real // side) % 16) * 256 + ((here.imag // side) % 16) * 16 + heading % 16, dtype=np.int64
        )

    def _pass_goals(self, labels: _Labels, step: int) -> None:
        labels = labels.pick(np.isfinite(self.reward[labels.stage, labels.frame]))
        if len(labels) == 0:
            return
        leg = (step - labels.begun).astype(np.float64)
        windows = np.array([goal.window for goal in self.goals[1:]])[labels.stage] - labels.clock[:, None]
        warped = np.round(np.clip(leg, windows[:, 0], windows[:, 1]))
        stretch = warped / np.maximum(leg, 1)
        limit = self.options.warp + 1e-9
        fine = (stretch >= 1 - limit) & (stretch <= 1 + limit) & (leg <= self.options.longest) & (warped > 0)
        cost = labels.cost + self.reward[labels.stage, labels.frame]
        cost = cost + self.options.warp_fee * np.log(np.maximum(stretch, 1e-9)) ** 2
        extra, turn, shift = self._meet_places(labels)
        arrived = labels.with_values(
            cost=cost + extra, clock=labels.clock + warped, begun=np.full(len(labels), step), turn=turn, shift=shift
        ).pick(fine & np.isfinite(extra))
        self._record(arrived.pick(arrived.stage == len(self.goals) - 2), step)
        onward = arrived.pick(arrived.stage < len(self.goals) - 2)
        if len(onward):
            stage = onward.stage + 1
            node = self.nodes.add(onward.node, onward.frame, step, stage, np.full(len(onward), -1))
            self._commit(onward.with_values(stage=stage, node=node), step + self.graph.commit)

    def _record(self, finished: _Labels, step: int) -> None:
        if len(finished):
            i = int(finished.cost.argmin())
            if self.best is None or finished.cost[i] < self.best[0]:
                self.best = (float(finished.cost[i]), int(finished.node[i]), step, float(finished.clock[i]))

    def _meet_places(self, labels: _Labels) -> tuple[FloatArray, ComplexArray, ComplexArray]:
        """Costs of missing places, and the transforms by which they are met after all."""
        extra = np.zeros(len(labels))
        turn, shift = labels.turn.copy(), labels.shift.copy()
        for stage, goal in enumerate(self.goals[1:]):
            here = labels.stage == stage
            if goal.heading is not None:
                off = np.exp(1j * goal.heading) / (turn * self.facing[labels.frame])
                missed = np.abs(np.angle(off))
                cost = np.where(missed > self.options.most_heading, np.inf, (missed / self.options.heading_scale) ** 2)
                at = turn * self.ground[labels.frame] + shift
                extra = np.where(here, extra + cost, extra)
                turn = np.where(here, turn * off, turn)
                shift = np.where(here, at - turn * self.ground[labels.frame], shift)
            if goal.place is not None:
                gap = goal.place - (turn * self.ground[labels.frame] + shift)
                cost = np.where(np.abs(gap) > goal.reach, np.inf, (np.abs(gap) / self.options.place_scale) ** 2)
                extra = np.where(here, extra + cost, extra)
                shift = np.where(here, shift + gap, shift)
        return extra, turn, shift

    def _play(self, labels: _Labels, step: int) -> None:
        on = labels.pick(labels.frame < self.graph.last[labels.frame])
        self._wait(on.with_values(frame=on.frame + 1, cost=on.cost + self.options.step_fee), step + 1)

    def _jump(self, labels: _Labels, step: int) -> None:
        starts = self.graph.starts
        counts = starts[labels.frame + 1] - starts[labels.frame]
        if counts.sum() == 0:
            return
        row = np.repeat(np.arange(len(labels)), counts)
        edge = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts) + starts[labels.frame][row]
        labels = labels.pick(row)
        target, on = self.graph.target[edge], labels.frame + 1
        spent = (1 + self.graph.commit) * self.options.step_fee
        turn = labels.turn * self.facing[on] / self.facing[target]
        shift = labels.turn * self.ground[on] + labels.shift - turn * self.ground[target]
        landed = labels.with_values(
            frame=target, cost=labels.cost + self.graph.cost[edge] + spent, turn=turn, shift=shift
        )
        later = landed.with_values(frame=target + self.graph.commit)
        bound = self._bound(later, step + 1 + self.graph.commit)
        keep = bound < (self.best[0] if self.best else np.inf)
        if keep.any():
            landed = landed.pick(keep)
            node = self.nodes.add(landed.node, landed.frame, step + 1, landed.stage, edge[keep])
            self._commit(landed.with_values(node=node), step + 1 + self.graph.commit)

    def _finish(self) -> Walk | None:
        if self.best is None:
            return None
        cost, node, step, clock = self.best
        stays = self.nodes.trace(node)
        passed = [0, *(b.step for a, b in itertools.pairwise(stays) if b.stage > a.stage), step]
        return Walk(stays, tuple(passed), self._clocks(passed, clock), cost)

    def _clocks(self, passed: list[int], final: float) -> tuple[float, ...]:
        clocks = [0.0]
        for leg, goal in zip(np.diff(passed), self.goals[1:], strict=True):
            clocks.append(clocks[-1] + float(np.round(np.clip(leg, *(np.array(goal.window) - clocks[-1])))))
        assert abs(clocks[-1] - final) < 1e-6
        return tuple(clocks)


def search(
    graph: Graph, goals: list[Goal], ground: ComplexArray, facing: ComplexArray, options: SearchOptions | None = None
) -> Walk | None:
    """The cheapest walk from a frame of the first goal through all others, or None.

    ground, facing ``(N,)``: where each frame's root is on its recording's ground, z + i x, and the unit complex number
    of its heading.
    """
    return _Search(graph, goals, ground, facing, options or SearchOptions()).run()
