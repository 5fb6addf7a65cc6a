# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigs whose bones are driven by control bones."""


def driven(rig):
    return False
