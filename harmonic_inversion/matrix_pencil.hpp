// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/damped_pole.hpp"

#include <vector>

namespace twang {

/// Poles of a short evenly sampled signal by the matrix pencil method: the Hankel matrix of the
/// samples is cut to `order` singular vectors V, and the shift within them has the poles as
/// eigenvalues.
///
///     Y = [y_{i+j}],  Y = U S V^T,   V2 = V1 X in (total) least squares,   u = eig(X)
///                                                      [Hua & Sarkar 1990; pencil length N / 3]
///
/// Serves where a record is too short or too damped for filter diagonalization.
///
/// @param order  singular vectors kept: two a damped sinusoid, one a real exponential or offset;
///               0: all before the one great fall of the singular values, where noise is no more
///               than round-off, else all that stand out of the median
/// @return       poles with positive frequency, slowest decay first; amplitudes are not estimated
/// Cost: cubic in the number of samples.
[[nodiscard]] std::vector<PoleCandidate> matrix_pencil(const EvenSeries& signal, int order);

/// The same for several orders at the price of one.
[[nodiscard]] std::vector<std::vector<PoleCandidate>> matrix_pencil(const EvenSeries& signal,
                                                                    const std::vector<int>& orders);

}  // namespace twang
