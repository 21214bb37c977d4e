// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "calibrate/choose_mode.hpp"
#include "core/material.hpp"
#include "core/progress.hpp"
#include "core/trace.hpp"
#include "harmonic_inversion/invert_harmonics.hpp"
#include "rigs/rig.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace twang {

struct PredictionOptions {
  std::vector<std::string> columns;  ///< inverted; empty: the observable if there is one, else all
  std::string time_column = "time_s";
  InversionOptions inversion;
  std::optional<int> mode;  ///< that the strongest sinusoid is, from 0; absent: chosen
  /// Unknowns that a reference mesh may have; what is left uncertain enters the prediction's sigma.
  long max_dofs = 100000;
  ProgressCallback progress = {};
};

/// A frequency and a decay with a standard deviation each.
struct PredictedMotion {
  double frequency_hz = kNaN;
  double frequency_sigma_hz = kNaN;
  double decay_per_s = kNaN;
  double decay_sigma_per_s = kNaN;
};

/// A rig's vibration foretold from the material that another rig gave, beside its trace.
struct Prediction {
  PredictedMotion same_b;             ///< with E and b of the material
  PredictedMotion same_tan_delta;     ///< with its tan delta in place of its b
  double lambda_per_s2 = kNaN;        ///< of the rig, at E, sag included [1/s²]
  double prestress_factor = 1.0;      ///< by which gravity changes it [-]
  double mesh_relative_sigma = 0.0;   ///< of lambda, what the mesh leaves uncertain [-]
  DampedSinusoid tracked;             ///< the strongest
  double frequency_error_rel = kNaN;  ///< predicted over tracked, minus one [-]
  double decay_error_rel = kNaN;      ///< the same of the decay, with the same b [-]
  double tan_delta_error_rel = kNaN;  ///< the same of the decay, with the same tan delta [-]
  double damping_ratio_of_b = kNaN;   ///< tracked b over the material's [-]
  double damping_exponent = kNaN;     ///< m of b ~ f^m between the two [-]
  ModeChoice mode;
  Trace trace;
  std::string column;  ///< the first that was inverted
  InversionResult inversion;
  std::vector<std::string> sentences;  ///< what came out, for a person
  std::vector<std::string> warnings;
  std::vector<std::string> remarks;
};

/// Predicts frequency and decay of the mode that a trace shows, by the rig's eigenmodes at the
/// identified modulus in the limit of fine meshes, added weights and the sag under gravity
/// included:
///
///     lambda = E lambda_k(1 Pa),  d = b lambda / 2,  2 pi f = sqrt(lambda − d²)
///
/// and compares. Linear: at small amplitude. Sigmas are the material's of E (all of its budget) and
/// b, and the mesh's.
/// @throws InputError if the rig is made of another material than `material`, or as
/// `calibrate_from_traces`; NumericalFailure if the trace holds no vibration; Cancelled
[[nodiscard]] Prediction predict_motion(const Rig& rig,
                                        const Material& material,
                                        const std::filesystem::path& trace,
                                        const PredictionOptions& options = {});

/// The tracked sinusoid's motion from its own start on with another frequency and decay, in the
/// column's unit: the first channel, offset left out.
[[nodiscard]] std::vector<double> motion_from_tracked_start(const Prediction& prediction,
                                                            const PredictedMotion& motion,
                                                            const std::vector<double>& time_s);

}  // namespace twang
