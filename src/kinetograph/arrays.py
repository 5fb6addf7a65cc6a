"""Names for the array types in signatures; docstrings give the shapes."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
"""Array of float64."""
IntArray = npt.NDArray[np.int64]
"""Array of int64."""
BoolArray = npt.NDArray[np.bool_]
"""Array of booleans."""
ComplexArray = npt.NDArray[np.complex128]
"""Array of complex128; places on the ground are z + i x."""
SingleArray = npt.NDArray[np.float32]
"""Array of float32, as kernels and files hold them."""
