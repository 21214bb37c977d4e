// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <array>
#include <complex>

namespace twang {

/// sum_{n < count} n^q e^(s n), q = 0, 1, 2, without cancellation however close e^s is to 1: by
/// doubling the number of terms there, else
///
///     (1 - z) S_0 = 1 - z^N,   (1 - z) S_1 = z S_0 - N z^N,   (1 - z) S_2 = z (S_0 + 2 S_1) - N²
///     z^N
///
/// @param s     exponent of one step
/// @param last  e^(s count), which the caller has
[[nodiscard]] std::array<std::complex<double>, 3> geometric_moments(std::complex<double> s,
                                                                    Eigen::Index count,
                                                                    std::complex<double> last);

}  // namespace twang
