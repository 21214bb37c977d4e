// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "calibrate/simulated_observable.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/constants.hpp"

#include <Eigen/Core>

#include <string>

namespace twang::detail {

/// Takes ln E_n and ln (b sqrt E_n) to ln E_n and ln b.
[[nodiscard]] Eigen::Matrix2d from_parameters();

/// By how much more than noise does it the first and the second half of a recording differ in
/// ln E_n and ln b, as variances: what the simulation's own faults leave uncertain.
/// @param columns   weighed, d simulated / d parameters (see `FollowedResiduals`)
/// @param left      the weighed residual
/// @param variance  of its noise
[[nodiscard]] Eigen::Array2d variance_between_halves(const Eigen::MatrixXd& columns,
                                                     const Eigen::VectorXd& left,
                                                     double variance);

/// What a refinement is judged by.
struct RefinementFit {
  Eigen::Vector2d change = Eigen::Vector2d::Constant(kNaN);      ///< of ln E_n and ln b
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Constant(kNaN);  ///< of the same
  double residual_rel = kNaN;         ///< rms left over the amplitude [-]
  double linear_residual_rel = kNaN;  ///< the same before [-]
};

/// Why the fit is worth nothing, a clause of a sentence: E_n and b are vague, or much of the motion
/// is left over. Empty: it is not so.
[[nodiscard]] std::string fault_of(const RefinementFit& fit);

/// That E_n and b are no others than before as far as the trace tells, with their figures, or that
/// the trace is followed no better. Empty: they are others.
[[nodiscard]] std::string agreement_of(const RefinementFit& fit);

/// Why a motion of the observable says too little about how far the part bends: its eigenmode
/// `mode` moves the rest of the part far more. A clause likewise; empty: it is not so.
[[nodiscard]] std::string fault_of_view(const SimulatedObservable& observable,
                                        const Eigenmodes& modes,
                                        int mode);

}  // namespace twang::detail
