// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/predict.hpp"

#include "calibrate/detail/trace_columns.hpp"
#include "coarsen/fit_material.hpp"
#include "coarsen/follow_mode.hpp"
#include "coarsen/prestress.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "core/trace_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

namespace fs = std::filesystem;

/// The part's material in the rig: that of the calibration.
const RigMaterial& material_in(const Rig& rig, const Material& material) {
  for (const PartSolid& solid : as_solids(rig).parts) {
    if (solid.material == material.material) continue;
    throw InputError(
        fmt::format("{}: the part is made of \"{}\", the calibration is of \"{}\"; "
                    "must be the same",
                    rig.file.string(),
                    solid.material,
                    material.material));
  }
  return *rig.find_material(material.material);
}

void note_differences(const RigMaterial& in_rig, const Material& material, Prediction& prediction) {
  constexpr double kSame = 1e-6;
  if (std::abs(in_rig.density_kg_m3 / material.density_kg_m3 - 1.0) > kSame) {
    prediction.warnings.push_back(
        fmt::format("The rig's density is {} kg/m³, the calibration's {}.",
                    in_rig.density_kg_m3,
                    material.density_kg_m3));
  }
  if (std::abs(in_rig.poissons_ratio - material.poissons_ratio) > kSame) {
    prediction.warnings.push_back(
        fmt::format("The rig's Poisson's ratio is {}, the calibration's {}.",
                    in_rig.poissons_ratio,
                    material.poissons_ratio));
  }
}

/// f and d of an eigenvalue and a decay, with their first-order sigmas.
PredictedMotion motion_of(double lambda,
                          double lambda_sigma_rel,
                          double decay,
                          double decay_sigma_rel) {
  PredictedMotion motion;
  const double w2 = lambda - decay * decay;
  const double w = std::sqrt(std::max(w2, 0.0));
  motion.frequency_hz = w / kTwoPi;
  motion.decay_per_s = decay;
  motion.decay_sigma_per_s = decay * decay_sigma_rel;
  if (w2 > 0.0) {
    motion.frequency_sigma_hz =
        std::hypot(0.5 * lambda * lambda_sigma_rel, decay * motion.decay_sigma_per_s) /
        (w * kTwoPi);
  }
  return motion;
}

void predict(const Rig& rig,
             const RigMaterial& in_rig,
             const Material& material,
             const PredictionOptions& options,
             Prediction& prediction) {
  LadderOptions ladder_options;
  ladder_options.max_dofs = options.max_dofs;
  ladder_options.progress = options.progress;
  const MeshLadder ladder = build_reference_ladder(rig, ladder_options);
  const MeshRung& finest = ladder.reference.back();
  ModeQuestion question;
  question.rig = &rig;
  question.rung = &finest;
  question.sinusoids = prediction.inversion.modes;
  question.columns = prediction.inversion.channel_names;
  question.motion =
      marker_motion(rig, prediction.trace, prediction.inversion.modes, prediction.inversion);
  question.reported_modulus_pa = material.youngs_modulus_identified_pa;
  question.stated = options.mode;
  prediction.mode = choose_mode(question);
  const int mode = prediction.mode.mode;
  const RichardsonLimit limit = limit_of_mode(ladder, mode);
  const double E = material.youngs_modulus_identified_pa;
  const MeshRung& light = ladder.reference.front();
  prediction.prestress_factor = prestress_factor(rig,
                                                 light,
                                                 {E, in_rig.poissons_ratio, in_rig.density_kg_m3},
                                                 follow_mode(finest, mode, light).mode);
  const double lambda = E * limit.lambda_per_s2 * prediction.prestress_factor;
  prediction.lambda_per_s2 = lambda;
  prediction.mesh_relative_sigma = limit.relative_sigma;
  const double modulus_rel = material.youngs_modulus_identified_sigma_pa / E;
  const double lambda_rel =
      std::hypot(std::isfinite(modulus_rel) ? modulus_rel : 0.0, limit.relative_sigma);
  const double b = material.damping_stiffness_b_s;
  const double b_rel = material.damping_stiffness_b_sigma_s / b;
  prediction.same_b =
      motion_of(lambda, lambda_rel, 0.5 * b * lambda, std::hypot(b_rel, lambda_rel));
  prediction.same_tan_delta = motion_of(lambda,
                                        lambda_rel,
                                        0.5 * material.tan_delta * std::sqrt(lambda),
                                        std::hypot(b_rel, 0.5 * lambda_rel));
  for (const std::string& note : ladder.notes) prediction.remarks.push_back(note);
  prediction.remarks.push_back(prediction.mode.reason);
  if (!prediction.mode.doubt.empty()) prediction.warnings.push_back(prediction.mode.doubt);
}

std::string percent(double relative) {
  return fmt::format("{}{} %", relative > 0.0 ? "+" : "", rounded_text(100.0 * relative, 2));
}

void compare(const Material& material, Prediction& prediction) {
  const DampedSinusoid& tracked = prediction.tracked;
  const PredictedMotion& predicted = prediction.same_b;
  const PredictedMotion& by_tan_delta = prediction.same_tan_delta;
  prediction.frequency_error_rel = predicted.frequency_hz / tracked.frequency_hz - 1.0;
  prediction.decay_error_rel = predicted.decay_per_s / tracked.decay_per_s - 1.0;
  prediction.tan_delta_error_rel = by_tan_delta.decay_per_s / tracked.decay_per_s - 1.0;
  prediction.damping_ratio_of_b = tracked.damping_stiffness_b_s() / material.damping_stiffness_b_s;
  const double span =
      std::log(tracked.natural_frequency_hz() * kTwoPi / std::sqrt(material.lambda_per_s2));
  constexpr double kLeastSpan = 0.05;  // of ln f: a slope over less says nothing
  if (std::abs(span) > kLeastSpan) {
    prediction.damping_exponent = std::log(prediction.damping_ratio_of_b) / span;
  }
  prediction.sentences.push_back(
      fmt::format("Frequency: predicted {} Hz, tracked {} Hz, {}.",
                  text_with_sigma(predicted.frequency_hz, predicted.frequency_sigma_hz),
                  text_with_sigma(tracked.frequency_hz, tracked.frequency_sigma_hz),
                  percent(prediction.frequency_error_rel)));
  prediction.sentences.push_back(
      fmt::format("Decay: predicted {} 1/s with the b of {} Hz, tracked {} 1/s, {}.",
                  text_with_sigma(predicted.decay_per_s, predicted.decay_sigma_per_s),
                  rounded_text(material.frequency_hz, 4),
                  text_with_sigma(tracked.decay_per_s, tracked.decay_sigma_per_s),
                  percent(prediction.decay_error_rel)));
  constexpr double kSigmas = 2.0;
  const double sigma = std::hypot(predicted.decay_sigma_per_s, tracked.decay_sigma_per_s);
  const double miss = std::abs(predicted.decay_per_s - tracked.decay_per_s);
  if (miss <= kSigmas * sigma) {
    prediction.sentences.emplace_back("One b holds at both frequencies within the uncertainty.");
    return;
  }
  prediction.sentences.push_back(
      fmt::format("The decay misses because b depends on frequency: tracked here is {} times that "
                  "at {} Hz{}. The "
                  "decay is off by a factor of {}, of which {} is the eigenvalue's.",
                  rounded_text(prediction.damping_ratio_of_b, 3),
                  rounded_text(material.frequency_hz, 4),
                  std::isfinite(prediction.damping_exponent)
                      ? fmt::format(", b ~ f^{}", rounded_text(prediction.damping_exponent, 2))
                      : "",
                  rounded_text(tracked.decay_per_s / predicted.decay_per_s, 3),
                  rounded_text(tracked.lambda_per_s2() / prediction.lambda_per_s2, 3)));
  prediction.sentences.push_back(
      fmt::format("One tan delta at both frequencies ({} at {} Hz, tracked {} here) would give {} "
                  "1/s, {}.",
                  rounded_text(material.tan_delta, 3),
                  rounded_text(material.frequency_hz, 4),
                  rounded_text(2.0 * tracked.damping_ratio(), 3),
                  rounded_text(by_tan_delta.decay_per_s, 3),
                  percent(prediction.tan_delta_error_rel)));
}

}  // namespace

Prediction predict_motion(const Rig& rig,
                          const Material& material,
                          const fs::path& trace,
                          const PredictionOptions& options) {
  const RigMaterial& in_rig = material_in(rig, material);
  Prediction prediction;
  note_differences(in_rig, material, prediction);
  prediction.trace = read_trace_csv(trace, options.time_column);
  const std::vector<std::string> columns =
      detail::columns_to_invert(rig, prediction.trace, trace, options.columns);
  try {
    prediction.inversion = invert_harmonics(prediction.trace, columns, options.inversion);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", trace.string(), error.what()));
  }
  if (!prediction.inversion.usable()) {
    throw NumericalFailure(fmt::format(
        "{}: no vibration was found: {}", trace.string(), prediction.inversion.message));
  }
  prediction.column = columns.front();
  prediction.tracked = prediction.inversion.modes.front();
  prediction.warnings.insert(prediction.warnings.end(),
                             prediction.inversion.notes.begin(),
                             prediction.inversion.notes.end());
  prediction.remarks = prediction.inversion.remarks;
  predict(rig, in_rig, material, options, prediction);
  compare(material, prediction);
  return prediction;
}

std::vector<double> motion_from_tracked_start(const Prediction& prediction,
                                              const PredictedMotion& motion,
                                              const std::vector<double>& time_s) {
  // From the tracked displacement and velocity at the time origin.
  const DampedSinusoid& tracked = prediction.tracked;
  const SinusoidInChannel& channel = tracked.channels.front();
  const double start = channel.amplitude * std::sin(channel.phase_rad);
  const double rate =
      channel.amplitude * (kTwoPi * tracked.frequency_hz * std::cos(channel.phase_rad) -
                           tracked.decay_per_s * std::sin(channel.phase_rad));
  const double w = kTwoPi * motion.frequency_hz;
  std::vector<double> y;
  y.reserve(time_s.size());
  for (const double time : time_s) {
    const double tau = time - prediction.inversion.time_origin_s;
    const double sine = w > 0.0 ? std::sin(w * tau) / w : tau;
    y.push_back(std::exp(-motion.decay_per_s * tau) *
                (start * std::cos(w * tau) + (rate + motion.decay_per_s * start) * sine));
  }
  return y;
}

}  // namespace twang
