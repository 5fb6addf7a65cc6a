"""Panels are drawn into a layout that is not there, rows added and removed, and a timer's events made by hand."""

import functools
import time
from types import SimpleNamespace

import bpy
from common import WALKS, bezier, emptied, finish, installed, row

MODULE = "bl_ext.user_default.kinetograph"
installed()
tasks, operators, along, panels, recordings = (
    __import__(f"{MODULE}.{name}", fromlist=[name]) for name in ("tasks", "operators", "along", "panels", "recordings")
)


class Layout:
    """Takes what is drawn, and knows whether it is there."""

    drawn = 0

    def __getattr__(self, name):
        return lambda *given, **more: self

    def prop(self, data, name, **more):
        assert name in data.bl_rna.properties, name
        Layout.drawn += 1

    def prop_search(self, data, name, where, rows, **more):
        self.prop(data, name)
        self.prop(where, rows)

    def template_list(self, kind, name, data, listed, active, index, **more):
        assert hasattr(bpy.types, kind), kind
        self.prop(data, listed)
        self.prop(active, index)
        for item in getattr(data, listed):
            Drawn(getattr(bpy.types, kind)).draw_item(bpy.context, self, data, item, 0, active, index)

    def operator(self, name, **more):
        operator = getattr(bpy.ops.kinetograph, name.split(".")[1])
        Layout.drawn += 1
        return SimpleNamespace(**dict.fromkeys(operator.get_rna_type().properties.keys()))


class Drawn:
    """A panel or a list that draws itself as its class does."""

    def __init__(self, kind):
        self._kind, self.layout = kind, Layout()

    def __getattr__(self, name):
        return functools.partial(getattr(self._kind, name), self)


def drawn():
    """Draw every panel; how much."""
    before = Layout.drawn
    rooms = (*panels.CLASSES, *along.CLASSES, *recordings.CLASSES)
    for each in rooms:
        if issubclass(each, bpy.types.Panel) and (not hasattr(each, "poll") or each.poll(bpy.context)):
            Drawn(each).draw(bpy.context)
    return Layout.drawn - before


emptied(24)
thing = bezier("path", [(0, 0), (2, 1), (4, 0)])
settings = bpy.context.scene.kinetograph
few = drawn()
for kind in along.KINDS:
    bpy.ops.kinetograph.row_add(kind=kind)
    bpy.ops.kinetograph.row_add(kind=kind)
settings.keys[0].when = "ALONG"
many = drawn()
bpy.ops.kinetograph.walk(curve="path", library=WALKS)
bpy.ops.kinetograph.roles(armature=bpy.context.object.name)
bpy.ops.kinetograph.look(library=WALKS)
most = drawn()
row(
    "panels are drawn",
    20 < few < many < most,
    f"{few} fields and buttons, {many} with rows, {most} with takes and roles",
)
for kind in along.KINDS:
    bpy.ops.kinetograph.row_remove(kind=kind)
    bpy.ops.kinetograph.row_remove(kind=kind)
    bpy.ops.kinetograph.row_remove(kind=kind)
row("rows are added and removed", not along.asks(bpy.context.scene), "two of each kind, and none")


class Window(operators.KINETOGRAPH_OT_walk.__mro__[1]):
    """The operator as a window's events drive it."""

    curve, library, armature, speed, by_radius, keep_time, mirror = "path", WALKS, "", 1.0, False, True, False
    hips, along, bl_label = "NEAR", False, "Walk Along Curve"
    task, _made = operators.KINETOGRAPH_OT_walk.task, operators.KINETOGRAPH_OT_walk._made

    def __init__(self):
        self.said, self.status = [], []
        self._runner = tasks.Runner(self.task(bpy.context))

    def report(self, kind, text):
        self.said.append((kind, text))

    def _over(self, context, how):
        return how

    def event(self, kind):
        """What the operator does with an event."""
        context = SimpleNamespace(workspace=SimpleNamespace(status_text_set=self.status.append))
        return self.modal(context, SimpleNamespace(type=kind))


def until(window, seen):
    """Let the timer go on until something is seen, or it is over; what the operator answered last."""
    answer = {"RUNNING_MODAL"}
    while answer == {"RUNNING_MODAL"} and not seen(window):
        answer = window.event("TIMER")
        time.sleep(0.005)
    return answer


slices = __import__(f"{MODULE}.slices", fromlist=["slices"])
slices.Slice.over = lambda self: True  # a pause wherever one may be
before = len(bpy.data.objects), len(bpy.data.actions)
window = Window()
waiting = window.event("MOUSEMOVE")
until(window, lambda w: w._runner.writing)
writing, given_up = window.event("MOUSEMOVE"), window.event("ESC")
same = (len(bpy.data.objects), len(bpy.data.actions)) == before
good = waiting == {"PASS_THROUGH"} and writing == {"RUNNING_MODAL"} and given_up == {"CANCELLED"} and same
row("Esc while keys are written", good, "events pass through until then, and the scene is as it was")
window = Window()
answer = until(window, lambda w: False)
good = answer == {"FINISHED"} and window.said[0][0] == {"INFO"} and any("keys" in text for text in window.status)
row("the timer makes a walk", good, window.said[0][1])
finish()
