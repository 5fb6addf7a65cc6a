"""Sensor control (Xie 2009): a few body-worn accelerometers drive a whole body.

`SensorControl` is the configuration. `Guided`, `KernelRidge`, `Continuity`, `Interpolation` and `Optimisation` are its
syntheses, which
`WindowSmoothing`, `CausalSmoothing` and `NoSmoothing` may follow; `LocalModelSettings` says how the local models of the
latter two are learnt. The rest serves evaluation: examples without a library, local models that several syntheses
share, and configurations by name.
"""

from kinetograph.methods.sensor.by_name import REDUCTIONS, SMOOTHINGS, SYNTHESES, smoothing_named, synthesis_named
from kinetograph.methods.sensor.examples import Examples, Motions, SensorSetup, build_examples, example_motions
from kinetograph.methods.sensor.fitted import SensorFit
from kinetograph.methods.sensor.guiding import Guided, KernelRidge, PoseSynthesis
from kinetograph.methods.sensor.live import LiveSensor
from kinetograph.methods.sensor.local_models import LocalModels
from kinetograph.methods.sensor.model import SensorControl, SensorModel, fit_examples
from kinetograph.methods.sensor.pose_space import PoseSpace, without_heading
from kinetograph.methods.sensor.result import SensorSynthesis
from kinetograph.methods.sensor.root import RootIntegrator
from kinetograph.methods.sensor.settings import ByDensity, ByMean, LleReduction, LocalModelSettings, PcaReduction
from kinetograph.methods.sensor.smoothing import CausalSmoothing, NoSmoothing, WindowSmoothing
from kinetograph.methods.sensor.syntheses import Continuity, Interpolation, Optimisation
from kinetograph.methods.sensor.window import ReadingWindow

__all__ = [
    "REDUCTIONS",
    "SMOOTHINGS",
    "SYNTHESES",
    "ByDensity",
    "ByMean",
    "CausalSmoothing",
    "Continuity",
    "Examples",
    "Guided",
    "Interpolation",
    "KernelRidge",
    "LiveSensor",
    "LleReduction",
    "LocalModelSettings",
    "LocalModels",
    "Motions",
    "NoSmoothing",
    "Optimisation",
    "PcaReduction",
    "PoseSpace",
    "PoseSynthesis",
    "ReadingWindow",
    "RootIntegrator",
    "SensorControl",
    "SensorFit",
    "SensorModel",
    "SensorSetup",
    "SensorSynthesis",
    "WindowSmoothing",
    "build_examples",
    "example_motions",
    "fit_examples",
    "smoothing_named",
    "synthesis_named",
    "without_heading",
]
