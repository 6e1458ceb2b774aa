"""Numerics that know no physics: compiled kernels, statistics, a Runge-Kutta pair; arrays by what they hold."""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
Complex = npt.NDArray[np.complex128]
