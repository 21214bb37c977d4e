// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <complex>
#include <vector>

namespace twang {

/// sum_n x_n exp(-i 2 pi k n / length), k = 0 .. length / 2, the samples padded with zeros (FFTW).
/// They are let go before the transform takes its own memory.
[[nodiscard]] std::vector<std::complex<double>> fourier_transform(Eigen::VectorXd samples,
                                                                  std::size_t length);

/// The smallest number >= `length` with no prime factors but 2, 3 and 5.
[[nodiscard]] std::size_t fast_length(std::size_t length);

}  // namespace twang
