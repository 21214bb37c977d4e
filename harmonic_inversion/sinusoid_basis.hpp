// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "harmonic_inversion/damped_pole.hpp"

#include <Eigen/Core>

namespace twang {

/// The largest exponent of a growing pole; beyond it exp(-d t) is cut, so that its square stays
/// finite.
inline constexpr double kMaxGrowthExponent = 300.0;

/// `exp(-d t) cos 2 pi f t` and `exp(-d t) sin 2 pi f t` at every time, in the two columns of
/// `out`.
///
/// Runs of even stamps are filled by recurrence, u^(n+1) = u^n u, restarted often enough to keep
/// full precision.
void fill_sinusoid_columns(const DampedPole& pole,
                           const Eigen::VectorXd& time_s,
                           Eigen::Ref<Eigen::MatrixXd> out);

/// `a = q r` with orthonormal columns in `q` and an upper triangle `r`: twice Cholesky's factor of
/// the normal matrix, or Householder reflections where `a` is too close to losing rank.
void orthonormalize(const Eigen::MatrixXd& a, Eigen::MatrixXd& q, Eigen::MatrixXd& r);

}  // namespace twang
