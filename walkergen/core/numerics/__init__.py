"""Numerics without physics: compiled kernels, statistics, quantities with errors; types of arrays by their content."""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
Complex = npt.NDArray[np.complex128]
