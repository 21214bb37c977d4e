// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "calibrate/trace_follower.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/constants.hpp"
#include "core/material.hpp"
#include "core/progress.hpp"
#include "core/termination.hpp"
#include "core/trace.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "rigs/rig.hpp"

#include <string>
#include <vector>

namespace twang {

struct RefineMaterialOptions {
  double periods = 10.0;  ///< simulated, from the first sample of the inversion's window on
  double settling = 1.0;  ///< periods at the beginning that are not compared: a release excites
                          ///< overtones that soon die away and that the simulated start lacks
  double steps_per_period = 80.0;  ///< of the simulation; their period error is taken out,
                                   ///< what they do to a large motion beyond it is not
  int max_iterations = 12;
  double relative_step = 1e-5;  ///< stops when E_n and b move by no more than this part
  ProgressCallback progress = {};
  void check() const;  ///< throws InputError naming field, value, allowed range
};

/// A tracked motion to be followed, with the fitted sinusoids from which it starts.
struct RefinedRecording {
  const Trace* trace = nullptr;
  std::string column;
  const InversionResult* inversion = nullptr;  ///< of that column first of all
};

/// How a recording was followed at the end.
struct FollowedRecording {
  FollowedStart start;
  double residual_rms = kNaN;  ///< tracked minus simulated, in the column's unit
  double linear_rms = kNaN;    ///< the same before the first iteration
  double correlation = kNaN;   ///< of a residual with the next one [-]
  int num_samples = 0;
};

/// E_n and b by least squares on the simulation, beside those from which it started.
struct RefinedMaterial {
  double youngs_modulus_numerical_pa = kNaN;
  double modulus_sigma_rel = kNaN;  ///< one sigma of E_n over E_n [-]
  double damping_stiffness_b_s = kNaN;
  double damping_sigma_rel = kNaN;  ///< one sigma of b over b [-]
  Refinement change;                ///< as the material file keeps it
  std::vector<FollowedRecording> recordings;
  int simulations = 0;
  Termination termination = Termination::NotRun;
  std::string message;  ///< why the linear estimate is to be kept, one sentence; empty: it is not
  bool agrees = false;  ///< it is kept because it could not be told from the refined one
  [[nodiscard]] bool usable() const {
    return termination == Termination::Converged && message.empty();
  }
};

/// That a trace's column is something whose place on the mesh is known.
/// @throws InputError if it is not
void check_refinable(const Rig& rig, const std::string& column);

/// Refines E_n and b of a coarse mesh so that its *nonlinear* simulation follows the tracked
/// observable: what a linear estimate takes for a softer or stiffer, more or less damped material
/// because a large motion is not a sum of damped sinusoids, is taken out.
///
///     minimize  sum_i w_i² (y_i - o - s(t_i; E_n, b, amplitude, phase))²
///
/// s is the observable of a `TraceFollower`; amplitude and phase of the start are every recording's
/// own, its offset o (and a drift, where the inversion saw one) is eliminated. Samples are weighed
/// by their stated sigmas. Levenberg-Marquardt (Ceres); without gravity the column of E_n is the
/// simulation's own time derivative, since
///
///     u(t; E, b, v0) = u(s t; E / s², b s, v0 / s)                                       s = any
///
/// and the others are differences of simulations, updated by Broyden's formula. The covariance is
/// that of all parameters, scaled by what is left over and widened for the correlation of
/// neighbouring residuals. Samples far off are left out.
///
/// The linear estimate is to be kept, and the message says why, where too little of the motion is
/// there, where the eigenmode hardly moves the observable, where a simulation fails or the fit does
/// not converge or goes astray, where the trace does not tell E_n and b or the simulation does not
/// follow it, and where they move by no more than chance lets them.
///
/// @param material  the linear estimate: E_n, b, a, nu and rho are used
/// @param mode      of `coarse` that the strongest sinusoid is, from 0
/// @throws InputError if a trace's column is nothing whose place on the mesh is known; Cancelled
[[nodiscard]] RefinedMaterial refine_material(const Rig& rig,
                                              const MeshRung& coarse,
                                              const Material& material,
                                              const std::vector<RefinedRecording>& recordings,
                                              int mode = 0,
                                              const RefineMaterialOptions& options = {});

}  // namespace twang
