// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/invert_harmonics.hpp"

#include <Eigen/Core>

#include <complex>

namespace twang {

/// amplitude e^(s t) at many times: where these are even, by products from one to the next instead
/// of exponentials.
[[nodiscard]] Eigen::VectorXcd exponentials(std::complex<double> amplitude,
                                            std::complex<double> s,
                                            const Eigen::Ref<const Eigen::VectorXd>& time_s);

/// `InversionResult::evaluate` at many times: where these are even, by products from one to the
/// next instead of exponentials.
///
/// @param time_s  from the origin of the channel on [s]
[[nodiscard]] Eigen::VectorXd evaluate_modes(const InversionResult& result,
                                             std::size_t channel,
                                             const Eigen::VectorXd& time_s);

}  // namespace twang
