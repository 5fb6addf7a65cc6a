"""How well held-out walks are performed: leave one take out on data/walks/15_01, 15_03, 15_09."""

from __future__ import annotations

from benchmarks._recordings import walker
from kinetograph.evaluation.protocol import leave_one_take_out
from kinetograph.methods.performance import PerformanceControl


def main() -> None:
    if not walker.real:
        print("no recordings: set KINETOGRAPH_DATA to a folder with walks/15_*.bvh")
        return
    print("take    control  joints   planted feet m/s   largest acceleration near seams   x real time")
    print("             cm      cm   ours    recorded   ours  recorded  (of p99 frames)")
    for row in leave_one_take_out(PerformanceControl(), walker.library):
        print(
            f"{row.take:7s} {row.control_cm:7.2f} {row.joint_cm:7.2f}   {row.slide:.3f}   {row.slide_recorded:.3f}     "
            f"{row.seam:5.2f}     {row.seam_recorded:5.2f}                   {row.times_real_time:10.0f}"
        )
        print(
            f"        of the p99 of all joints' accelerations: {row.seam_all:.2f}, recorded {row.seam_all_recorded:.2f}"
        )
