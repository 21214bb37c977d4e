// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "calibrate/trace_follower.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/material.hpp"
#include "core/progress.hpp"
#include "core/trace.hpp"
#include "harmonic_inversion/damped_pole.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "rigs/rig.hpp"
#include "simulate/integrators.hpp"

#include <Eigen/Core>

#include <functional>
#include <string>
#include <vector>

namespace twang {

/// Sees how a mesh is bent, u (3 num_nodes) [m], at a time of the trace [s].
using MeshObserver =
    std::function<void(const HexMesh& mesh, double time_s, const Eigen::VectorXd& u)>;

/// The simulated observable beside the tracked one, on the tracked time stamps.
struct Validation {
  std::vector<double> time_s;       ///< of the tracked samples used [s]
  std::vector<double> tracked;      ///< offset removed, in the observable's unit at the user's edge
  std::vector<double> simulated;    ///< the same unit
  std::vector<double> fine_time_s;  ///< of every step [s]
  std::vector<double> fine_simulated;
  std::string unit;                              ///< "mm", "rad" or the channel's own
  DampedPole tracked_sinusoid = {kNaN, kNaN};    ///< the strongest, in these samples
  DampedPole simulated_sinusoid = {kNaN, kNaN};  ///< likewise
  ValidationFigures figures;
  RunSummary run;
  double step_s = 0.0;
};

/// Starts the coarse mesh where the fitted modes say the rig was at their time origin, lets it go
/// (neo-Hookean, trapezoidal Newmark, Rayleigh b) for ten periods and compares. No time shift is
/// fitted.
/// @param mode   of `coarse` that the strongest sinusoid is, from 0
/// @param start  a departure from the fitted modes at their time origin, as a refinement found it
[[nodiscard]] Validation validate_against_trace(const Rig& rig,
                                                const MeshRung& coarse,
                                                const Material& material,
                                                const Trace& trace,
                                                const std::string& column,
                                                const InversionResult& inversion,
                                                const ProgressCallback& progress = {},
                                                int mode = 0,
                                                const MeshObserver& on_state = {},
                                                const FollowedStart& start = {});

}  // namespace twang
