"""The search through a transition graph against enumeration, its bounds, and the graph itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive_keyframe as naive
from kinetograph.learn.goals import (
    Goal,
    SearchOptions,
    Tolls,
    Way,
    costs_on_the_way,
    costs_to_go,
    least_interval,
    least_steps,
)
from kinetograph.learn.routes import OpenRoutes
from kinetograph.learn.timed_problem import expected_costs, prepare
from kinetograph.learn.timed_search import find_route
from kinetograph.learn.transitions import (
    Graph,
    bar,
    discourage,
    find_transitions,
    keep_transitions,
    last_frames,
    make_graph,
)

EXACT = SearchOptions(beam=100_000, warp=0.0)


def small_graph(rng: np.random.Generator, commit: int) -> Graph:
    last = last_frames([int(n) for n in rng.integers(3, 7, size=3)])
    inner = np.flatnonzero(np.arange(len(last)) < last)
    source, target = rng.choice(inner, 24), rng.integers(len(last), size=24)
    return make_graph(last, source, target, rng.random(24), commit)


def goal(rng: np.random.Generator, count: int, at: int) -> Goal:
    frames = rng.choice(count, 6, replace=False)
    tolls = Tolls(rng.random(count), 2.0 * rng.random(), rng.random()) if rng.random() < 0.5 else None
    return Goal(frames, rng.random(6), (at, at), tolls=tolls)


def flat(graph: Graph) -> tuple[np.ndarray, np.ndarray]:
    return np.zeros(len(graph), dtype=complex), np.ones(len(graph), dtype=complex)


@settings(max_examples=60)
@given(st.integers(0, 100_000), st.integers(1, 2), st.integers(2, 8), st.booleans())
def test_the_search_finds_what_enumeration_finds(seed: int, commit: int, steps: int, three: bool):
    rng = np.random.default_rng(seed)
    graph = small_graph(rng, commit)
    times = [0, steps // 2, steps] if three and steps >= 4 else [0, steps]
    goals = [goal(rng, len(graph), t) for t in times]
    best = naive.cheapest_route(graph, goals, steps)
    route = find_route(graph, goals, *flat(graph), EXACT)
    if not np.isfinite(best):
        assert route is None
        return
    assert route is not None
    assert route.cost == pytest.approx(best)
    assert list(route.passed) == times
    assert list(route.clocks) == times


@settings(max_examples=40)
@given(st.integers(0, 100_000), st.integers(1, 2))
def test_bounds_never_exceed_what_a_route_costs_or_takes(seed: int, commit: int):
    rng = np.random.default_rng(seed)
    graph = small_graph(rng, commit)
    start, stop = goal(rng, len(graph), 0), goal(rng, len(graph), 0)
    least = least_interval(graph, start, stop)
    for steps in range(1, 9):
        exact = Goal(stop.frames, stop.costs, (steps, steps), tolls=stop.tolls)
        route = find_route(graph, [start, exact], *flat(graph), EXACT)
        assert (route is None) or steps >= least
        if route is not None:
            own = costs_on_the_way(graph, exact, 0.0)
            bound = costs_to_go(graph, [exact], [np.inf], [own])[0]
            first = route.segments[0].frame
            assert route.cost >= bound[first + commit] + own.start[first] - 1e-9
    if np.isfinite(least):
        least_goal = Goal(stop.frames, stop.costs, (least, least))
        assert find_route(graph, [start, least_goal], *flat(graph), EXACT) is not None


def chain(lengths: list[int], jumps: list[tuple[int, int, float]], commit: int = 1) -> Graph:
    source, target, cost = (np.array(column) for column in zip(*jumps, strict=True))
    return make_graph(last_frames(lengths), source, target, cost.astype(float), commit)


def test_least_steps_count_played_frames_and_commitments():
    graph = chain([5, 5], [(1, 6, 0.5)], commit=2)
    stop = Goal(np.array([9]), np.zeros(1))
    # from 1: to 6, committed to 8 (3 steps), and on to 9
    assert least_steps(graph, stop)[[0, 1, 2, 8, 9]].tolist() == [5, 4, np.inf, 1, 0]


@settings(max_examples=60)
@given(st.integers(0, 100_000), st.integers(1, 3), st.integers(0, 12))
def test_least_steps_solve_bellmans_equation_up_to_the_most(seed: int, commit: int, most: int):
    rng = np.random.default_rng(seed)
    graph = small_graph(rng, commit)
    stop = goal(rng, len(graph), 0)
    exact = np.full(len(graph), np.inf)
    exact[stop.frames] = 0.0
    for _ in range(len(graph)):
        for i in range(len(graph)):
            ways = [exact[graph.target[e] + commit] + 1 + commit for e in range(graph.starts[i], graph.starts[i + 1])]
            ways += [exact[i + 1] + 1] if i < graph.last[i] else []
            exact[i] = min([exact[i], *ways])
    assert least_steps(graph, stop).tolist() == exact.tolist()
    assert least_steps(graph, stop, most).tolist() == np.where(exact <= most, exact, np.inf).tolist()


def test_a_warp_makes_up_for_a_missing_step_and_costs():
    graph = chain([30], [(0, 5, 9.0)])
    goals = [Goal(np.array([0]), np.zeros(1), (0, 0)), Goal(np.array([20]), np.zeros(1), (22, 22))]
    assert find_route(graph, goals, *flat(graph), EXACT) is None
    route = find_route(graph, goals, *flat(graph), SearchOptions(warp=0.15))
    assert route is not None
    assert route.passed == (0, 20)
    assert route.clocks == (0.0, 22.0)
    assert route.cost == pytest.approx(50 * np.log(1.1) ** 2)


def test_a_pinned_place_chooses_the_route_that_leads_there():
    # two recordings go left and right from where the first ends; the right one is dearer and yet asked for
    graph = chain([5, 10, 10], [(3, 5, 0.1), (3, 15, 0.3)])
    along = np.concatenate([np.arange(5.0), 1j * np.arange(10), -1j * np.arange(10)]).astype(complex)
    facing = np.ones(25, dtype=complex)
    ends = np.array([12, 22])
    start = Goal(np.array([0]), np.zeros(1), (0, 0), place=0j, heading=0.0)
    free = find_route(graph, [start, Goal(ends, np.zeros(2), (11, 11))], along, facing, EXACT)
    asked = find_route(graph, [start, Goal(ends, np.zeros(2), (11, 11), place=4 - 7j)], along, facing, EXACT)
    assert free is not None
    assert asked is not None
    assert [s.frame for s in free.segments] == [0, 5]
    assert [s.frame for s in asked.segments] == [0, 15]
    assert asked.cost == pytest.approx(0.3)
    far = Goal(ends, np.zeros(2), (11, 11), place=40 + 0j)
    assert find_route(graph, [start, far], along, facing, EXACT) is None


def test_discouraged_transitions_are_avoided():
    graph = chain([10, 40, 10], [(3, 10, 0.1), (3, 50, 0.2), (14, 50, 0.1)])
    goals = [Goal(np.array([0]), np.zeros(1), (0, 0)), Goal(np.array([16, 56]), np.zeros(2), (10, 10))]
    route = find_route(graph, goals, *flat(graph), EXACT)
    assert route is not None
    assert route.segments[-1].frame == 10
    other = find_route(discourage(graph, np.array([route.segments[-1].edge]), 5.0, 3), goals, *flat(graph), EXACT)
    assert other is not None
    assert other.segments[-1].frame == 50


def test_transitions_join_frames_whose_successors_meet():
    rng = np.random.default_rng(0)
    one = np.cumsum(rng.normal(size=(60, 3)), axis=0)
    other = np.cumsum(rng.normal(size=(60, 3)), axis=0) + 100
    other[30] = one[20]
    features = np.concatenate([one, other]).astype(np.float32)
    graph = find_transitions(features, last_frames([60, 60]), 3, limit=0.1, scale=0.1, fee=0.5)
    between = [
        (int(i), int(graph.target[e]), float(graph.cost[e]))
        for i in range(len(graph))
        for e in range(graph.starts[i], graph.starts[i + 1])
        if graph.last[i] != graph.last[graph.target[e]]
    ]
    # frame 19 may be followed by frame 60 + 30, which is like frame 20, and the other way round
    assert {(19, 90), (89, 20)} == {(i, j) for i, j, _ in between}
    assert all(cost == pytest.approx(0.5) for _, _, cost in between)


def joined_recordings(graph: Graph) -> set[tuple[int, int]]:
    left = np.repeat(graph.last, np.diff(graph.starts))
    return set(zip(left.tolist(), graph.last[graph.target].tolist(), strict=True))


def test_the_best_match_of_any_two_recordings_is_a_transition():
    rng = np.random.default_rng(1)
    # each recording of a place of its own, so that the nearest neighbours of most frames are in their own recording
    features = (rng.normal(size=(12, 1, 3)) * 5 + rng.normal(size=(12, 40, 3))).reshape(-1, 3).astype(np.float32)
    last = last_frames([40] * 12)
    graph = find_transitions(features, last, 1, limit=100.0, scale=1.0, fee=0.0)
    found = set(zip(np.repeat(np.arange(480), np.diff(graph.starts)).tolist(), graph.target.tolist(), strict=True))
    for a in range(12):
        for b in range(a + 1, 12):
            gaps = np.linalg.norm(features[40 * a + 1 : 40 * a + 40, None] - features[40 * b + 1 : 40 * b + 40], axis=2)
            i, j = 40 * a + 1 + int(gaps.argmin()) // 39, 40 * b + 1 + int(gaps.argmin()) % 39
            assert j == last[j] or (i - 1, j) in found
            assert i == last[i] or (j - 1, i) in found


def test_of_hundreds_of_recordings_any_is_reached_by_two_transitions():
    count = 400
    features = np.random.default_rng(2).normal(size=(count * 5, 6)).astype(np.float32)
    graph = find_transitions(features, last_frames([5] * count), 1, limit=100.0, scale=1.0, fee=0.0)
    joined = np.zeros((count, count), dtype=int)
    joined[tuple(np.array(sorted(joined_recordings(graph))).T // 5)] = 1
    assert joined.sum() < 0.95 * count * (count - 1)
    assert (joined @ joined + joined).min() > 0


def test_transitions_leave_room_for_the_shortest_stay():
    features = np.zeros((40, 2), dtype=np.float32)
    graph = find_transitions(features, last_frames([20, 20]), 7, limit=1.0, scale=1.0, fee=0.0)
    assert len(graph.target) > 0
    assert (graph.target + 7 <= graph.last[graph.target]).all()


def test_barred_frames_are_neither_played_nor_reached():
    graph = bar(chain([10, 10], [(2, 12, 0.1), (2, 17, 0.2), (14, 5, 0.3), (4, 8, 0.4)]), np.arange(20) == 14)
    assert graph.last[[0, 9, 13, 14, 15, 19]].tolist() == [9, 9, 13, 14, 19, 19]
    # 12 may be entered, with a frame to play; 14 is not left
    assert sorted(zip(graph.target.tolist(), graph.cost.tolist(), strict=True)) == [(8, 0.4), (12, 0.1), (17, 0.2)]
    assert least_steps(graph, Goal(np.array([19]), np.zeros(1)))[[10, 15]].tolist() == [np.inf, 4]


def test_some_transitions_are_kept():
    graph = chain([10, 10], [(2, 12, 0.1), (2, 16, 0.2), (4, 12, 0.3)])
    kept = keep_transitions(graph, np.array([False, True, True]))
    assert kept.target.tolist() == [16, 12]
    assert [int(kept.starts[i + 1] - kept.starts[i]) for i in (2, 3, 4)] == [1, 0, 1]


def test_recordings_are_joined_even_where_others_are_nearer():
    # ten stances all alike, a walk further off: by neighbours alone no stance would lead to it
    rng = np.random.default_rng(0)
    stances = [0.01 * rng.normal(size=(40, 3)) for _ in range(10)]
    features = np.concatenate([*stances, 0.3 + 0.01 * rng.normal(size=(40, 3))]).astype(np.float32)
    last = last_frames([40] * 11)
    graph = find_transitions(features, last, 3, limit=0.7, scale=0.1, fee=0.5)
    source = np.repeat(np.arange(len(graph)), np.diff(graph.starts))
    for stance in range(10):
        assert (last[graph.target[last[source] == 40 * stance + 39]] == 439).any()
    apart = find_transitions(features, last, 3, limit=0.2, scale=0.1, fee=0.5)
    assert not (last[apart.target[apart.starts[400] :]] < 400).any()


def test_most_of_a_narrow_beam_is_for_routes_that_get_to_the_place():
    # twenty recordings go on for less than the one that turns to where the goal is
    count, length = 21, 30
    jumps = [(3, 5 + length * i, 0.1 + 0.01 * i) for i in range(count - 1)]
    jumps += [(3, 5 + length * (count - 1), 5.0)]
    graph = chain([5, *[length] * count], jumps)
    ahead = np.arange(length, dtype=complex)
    ground = np.concatenate([np.arange(5.0), *[ahead] * (count - 1), 1j * ahead])
    facing = np.concatenate([np.ones(5), *[np.ones(length)] * (count - 1), [1, *[1j] * (length - 1)]])
    start = Goal(np.array([0]), np.zeros(1), (0, 0), place=0j, heading=0.0)
    ends = np.array([5 + length * (i + 1) - 5 for i in range(count)])
    goals = [start, Goal(ends, np.zeros(count), place=4 + 25j, reach=1.0)]
    narrow = SearchOptions(beam=5, warp=0.0, speed=2.0)
    assert find_route(graph, goals, ground, facing, narrow) is None
    route = find_route(graph, goals, ground, facing, replace(narrow, way=Way(1.0, 0.5, 2.0)))
    assert route is not None
    assert route.segments[-1].frame == 5 + length * (count - 1)


@settings(max_examples=40)
@given(st.integers(0, 100_000))
def test_what_the_way_to_a_place_costs_is_as_if_written_out(seed: int):
    rng = np.random.default_rng(seed)
    graph = small_graph(rng, 1)
    count, routes = len(graph), 9
    ground = 3 * (rng.normal(size=count) + 1j * rng.normal(size=count))
    facing = np.exp(1j * rng.uniform(-np.pi, np.pi, count))
    heading = None if rng.random() < 0.5 else float(rng.uniform(-np.pi, np.pi))
    goals = [Goal(np.array([0]), np.zeros(1), (0, 0)), Goal(np.array([1]), np.zeros(1)), goal(rng, count, 1)]
    goals[2] = replace(goals[2], place=complex(*rng.normal(size=2)), heading=heading, offset=0.2j)
    options, way = SearchOptions(longest=6), Way(0.4, 0.3, 0.7)
    problem = prepare(graph, goals, ground, facing, options)
    zeros = np.zeros(routes, dtype=np.int64)
    table = OpenRoutes(
        rng.integers(0, 2, routes),
        rng.integers(0, count, routes),
        np.zeros(routes),
        zeros,
        rng.integers(0, 3, routes),
        np.zeros(routes),
        np.exp(1j * rng.uniform(-np.pi, np.pi, routes)),
        rng.normal(size=routes) + 1j * rng.normal(size=routes),
    )
    found = expected_costs(problem, table, 4, way)
    for i in range(routes):
        frame = table.frame[i]
        if table.stage[i] == 0:  # its goal has no place
            assert found[i] == 0
            continue
        gap = goals[2].place - (table.rotation[i] * ground[frame] + table.shift[i])
        faces = np.angle(table.rotation[i] * facing[frame])
        near = min(abs(gap), 1.0)
        angle = near * (1 - np.cos(np.angle(gap) - faces))
        if heading is not None:
            angle += (1 - near) * (1 - np.cos(heading - faces))
        needed = max(abs(gap) - 0.2, 0) / 0.4 + np.pi / 2 * angle / 0.3
        latest = min((goals[2].window[1]) * 1.15, 6) - (4 - table.begun[i])
        late = max(needed - max(latest, 0), 0) * 0.4 / options.place_scale
        least = problem.steps[1, frame]
        more = max(needed - (least if np.isfinite(least) else 0), 0)
        assert found[i] == pytest.approx(late**2 + 0.7 * more, rel=1e-9)
