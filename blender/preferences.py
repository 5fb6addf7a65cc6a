# SPDX-License-Identifier: GPL-3.0-or-later
"""Where kinetograph is, and the button that installs it."""

import bpy
from bpy.props import StringProperty

from . import finding, tasks
from .link import Trouble


class KINETOGRAPH_AP_preferences(bpy.types.AddonPreferences):
    """Preferences of the extension."""

    bl_idname = __package__

    command: StringProperty(
        name="kinetograph",
        subtype="FILE_PATH",
        description="The program, or its virtual environment; found on the PATH unless given",
    )
    package: StringProperty(name="Package", default="kinetograph", description="What pip installs: a name, or a wheel")

    def draw(self, context):
        layout = self.layout
        layout.prop(self, "command")
        try:
            found = " ".join(finding.command(self.command, tasks.managed_folder()))
            layout.label(text=f"Found: {found}", icon="CHECKMARK")
        except Trouble as error:
            layout.label(text=str(error), icon="ERROR")
        row = layout.row()
        row.prop(self, "package")
        row.operator("kinetograph.install")


class KINETOGRAPH_OT_install(bpy.types.Operator):
    """Install kinetograph into an environment of its own, next to the extension"""

    bl_idname = "kinetograph.install"
    bl_label = "Install Kinetograph"

    def execute(self, context):
        """Install it, and wait."""
        installing = self._begin()
        installing.wait()
        return self._ended(installing)

    def invoke(self, context, event):
        """Install it while the interface goes on."""
        self._installing = self._begin()
        self._timer = context.window_manager.event_timer_add(0.2, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._installing.cancel()
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        context.workspace.status_text_set(f"Kinetograph: {self._installing.said[-100:]} (Esc to cancel)")
        if not self._installing.done:
            return {"RUNNING_MODAL"}
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)
        return self._ended(self._installing)

    def _begin(self):
        return finding.Installing(tasks.managed_folder(), tasks.preferences().package)

    def _ended(self, installing):
        if installing.error:
            self.report({"ERROR"}, installing.error)
            return {"CANCELLED"}
        self.report({"INFO"}, f"kinetograph is installed in {installing.folder}")
        return {"FINISHED"}


CLASSES = (KINETOGRAPH_AP_preferences, KINETOGRAPH_OT_install)
