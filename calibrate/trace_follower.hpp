// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "calibrate/simulated_observable.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/material.hpp"
#include "core/progress.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "rigs/rig.hpp"
#include "simulate/integrators.hpp"

#include <Eigen/Core>

#include <functional>
#include <string>
#include <vector>

namespace twang {

/// Where a mesh is let go, as a departure from what the fitted sinusoids say.
struct FollowedStart {
  double amplitude = 1.0;  ///< factor on the strongest sinusoid [-]
  double turn_rad = 0.0;   ///< added to its phase [rad]
  double velocity = 1.0;   ///< factor on all velocities [-]
};

/// How a mesh moved that was let go where the tracked motion began.
struct FollowedMotion {
  std::vector<double> time_s;      ///< of every step, in the trace's time [s]
  std::vector<double> observable;  ///< from rest, in the column's unit
  double step_s = 0.0;
  RunSummary run;  ///< why there is nothing, if so

  /// Linearly between the steps.
  [[nodiscard]] double at(double time_s) const;
};

/// The mesh of a rig that starts where the fitted modes of a trace say the rig was at their time
/// origin, and is let go: neo-Hookean, trapezoidal Newmark, Rayleigh damping, gravity if the rig
/// has it.
///
/// It is bent by the load sum lambda_k y_k M phi_k, scaled until the observable is the tracked one,
/// and moves as that shape changes with the fitted velocities: for small amplitudes its modes, for
/// large ones the way on which it shortens and turns.
class TraceFollower {
 public:
  /// Keeps references to all.
  /// @param column  of the trace that was inverted alone
  /// @param mode    of `rung` that the strongest sinusoid is, from 0
  TraceFollower(const Rig& rig,
                const MeshRung& rung,
                const InversionResult& inversion,
                const std::string& column,
                int mode);

  /// @param end_s            up to here, in the trace's time [s]
  /// @param steps_per_period  of the strongest sinusoid; made more where a step fails
  /// @param on_state         called with every state, its time in the trace's; may be empty
  /// @throws Cancelled
  [[nodiscard]] FollowedMotion follow(
      const ElasticMaterial& material,
      const FollowedStart& start,
      double end_s,
      double steps_per_period,
      const ProgressCallback& progress = {},
      const std::function<void(const BodyState&)>& on_state = {}) const;

  [[nodiscard]] const SimulatedObservable& observable() const { return m_observable; }

 private:
  const Rig* m_rig;
  const MeshRung* m_rung;
  const InversionResult* m_inversion;
  int m_mode;
  double m_si_per_unit;
  SimulatedObservable m_observable;
};

}  // namespace twang
