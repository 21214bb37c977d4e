// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/calibrate.hpp"

#include "calibrate/alias_check.hpp"
#include "calibrate/detail/material_of.hpp"
#include "calibrate/detail/trace_columns.hpp"
#include "calibrate/lack_of_fit.hpp"
#include "calibrate/window_stability.hpp"
#include "coarsen/follow_mode.hpp"
#include "core/error.hpp"
#include "core/trace_file.hpp"
#include "fem/read_mesh.hpp"
#include "harmonic_inversion/decay_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace twang {
namespace {

namespace fs = std::filesystem;

/// The materials of the part, its solids or its mesh file.
std::set<std::string> materials_of_part(const Rig& rig) {
  if (rig.meshing.file) {
    const std::vector<std::string> names = read_mesh_of(rig, ElementKind::Hex8).material_names;
    return {names.begin(), names.end()};
  }
  std::set<std::string> names;
  for (const PartSolid& solid : rig.parts) names.insert(solid.material);
  return names;
}

/// The one material whose modulus is to be found.
const RigMaterial& unknown_material(const Rig& rig) {
  const std::set<std::string> of_part = materials_of_part(rig);
  const RigMaterial* unknown = nullptr;
  for (const RigMaterial& material : rig.materials) {
    if (!of_part.contains(material.name)) continue;
    if (material.youngs_modulus_pa || unknown) {
      throw InputError(
          fmt::format("{}: materials.{}: the part is made of several materials or of one whose "
                      "youngs_modulus_pa is stated, must be "
                      "made of one material without it for calibrate",
                      rig.file.string(),
                      material.name));
    }
    unknown = &material;
  }
  if (unknown == nullptr) {
    throw InputError(
        fmt::format("{}: no material is used by a part, must be one", rig.file.string()));
  }
  return *unknown;
}

void invert_repeat(Repeat& repeat, const CalibrationOptions& options) {
  try {
    repeat.inversion = invert_harmonics(repeat.trace, repeat.columns, options.inversion);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", repeat.file.string(), error.what()));
  }
  if (!repeat.inversion.usable()) {
    throw NumericalFailure(fmt::format(
        "{}: no vibration was found: {}", repeat.file.string(), repeat.inversion.message));
  }
  repeat.inversion = with_decay_checks(std::move(repeat.inversion), repeat.trace);
  repeat.spectrum = amplitude_spectrum(repeat.trace,
                                       *repeat.trace.find(repeat.columns.front()),
                                       repeat.inversion.time_origin_s,
                                       repeat.inversion.time_end_s);
  repeat.model_spectrum = model_spectrum(repeat.trace, repeat.inversion);
}

/// Where the fundamental is heavily damped, its overtones are overdamped: let go, they creep back
/// with a rate of about 1 / b without swinging, and bend the beginning of the record. The window
/// then starts when they are gone, unless the user has stated its start.
void skip_creeping_overtones(Repeat& repeat,
                             CalibrationOptions& options,
                             Calibration& calibration) {
  constexpr double kHeavy = 0.15;  // damping ratio: a beam's second mode has six times that
  constexpr double kCreepTimes =
      2.5;  // of b: what is left of them against the fundamental is tenth
  constexpr double kPeriodsLeft = 1.0;
  const DampedSinusoid mode = repeat.inversion.modes.front();
  if (options.inversion.start_s || mode.damping_ratio() < kHeavy) return;
  const double start_s =
      repeat.inversion.time_origin_s + kCreepTimes * mode.damping_stiffness_b_s();
  if (start_s + kPeriodsLeft / mode.frequency_hz > repeat.inversion.time_end_s) return;
  InversionOptions later = options.inversion;
  later.start_s = start_s;
  const InversionResult found = invert_harmonics(repeat.trace, repeat.columns, later);
  if (!found.usable()) return;
  options.inversion = later;
  invert_repeat(repeat, options);
  calibration.remarks.push_back(
      fmt::format("So heavily damped a part's overtones creep back instead of swinging: the window "
                  "starts {:.3g} "
                  "s later, at {:.4g} s, when they are gone.",
                  kCreepTimes * mode.damping_stiffness_b_s(),
                  start_s));
}

void append(std::vector<std::string>& sentences, const std::vector<std::string>& more) {
  sentences.insert(sentences.end(), more.begin(), more.end());
}

/// All repeats share their poles; each keeps the window it was inverted in alone.
InversionResult invert_jointly(const std::vector<Repeat>& repeats,
                               const CalibrationOptions& options) {
  if (repeats.size() == 1) return repeats.front().inversion;
  std::vector<Trace> traces;
  for (const Repeat& repeat : repeats) {
    if (repeat.columns != repeats.front().columns) {
      throw InputError(fmt::format("{}: offers other columns than {}, must be repeats of one rig",
                                   repeat.file.string(),
                                   repeats.front().file.string()));
    }
    traces.push_back(repeat.trace);
  }
  InversionResult result = invert_repeats(traces, repeats.front().columns, options.inversion);
  if (!result.usable()) {
    throw NumericalFailure(fmt::format(
        "no vibration is common to the {} recordings: {}", repeats.size(), result.message));
  }
  return result;
}

/// The joint inversion's strongest sinusoid with what its windows and its residual add: the mean of
/// the repeats' spreads.
DampedSinusoid widened_fundamental(const Rig& rig,
                                   const Calibration& calibration,
                                   const CalibrationOptions& options) {
  WindowStability mean;
  WindowStability misfit;
  const auto count = static_cast<double>(calibration.repeats.size());
  for (const Repeat& repeat : calibration.repeats) {
    const WindowStability stability =
        window_stability(repeat.trace, repeat.columns, repeat.inversion, options.inversion);
    mean.frequency_spread_hz += stability.frequency_spread_hz / count;
    mean.decay_spread_per_s += stability.decay_spread_per_s / count;
    const LackOfFit lack = lack_of_fit(rig, repeat.trace, repeat.inversion);
    misfit.frequency_spread_hz += lack.frequency_spread_hz / count;
    misfit.decay_spread_per_s += lack.decay_spread_per_s / count;
  }
  return widened(widened(calibration.inversion.modes.front(), mean), misfit);
}

/// Which eigenmode the fundamental is, its limit and its number on the coarse mesh.
void find_mode(const Rig& rig,
               const RigMaterial& material,
               const CalibrationOptions& options,
               Calibration& calibration) {
  const Repeat& first = calibration.repeats.front();
  const MeshRung& finest = calibration.ladder.reference.back();
  ModeQuestion question;
  question.rig = &rig;
  question.rung = &finest;
  question.sinusoids = calibration.inversion.modes;
  question.columns = first.columns;
  question.motion = marker_motion(rig, first.trace, calibration.inversion.modes, first.inversion);
  question.reported_modulus_pa = material.reported_youngs_modulus_pa;
  question.stated = options.mode;
  calibration.mode = choose_mode(question);
  calibration.limit = limit_of_mode(calibration.ladder, calibration.mode.mode);
  const FollowedMode coarse = follow_mode(finest, calibration.mode.mode, calibration.ladder.coarse);
  calibration.coarse_mode = coarse.mode;
  calibration.remarks.push_back(calibration.mode.reason);
  if (!calibration.mode.doubt.empty()) calibration.warnings.push_back(calibration.mode.doubt);
  constexpr double kSameShape = 0.8;
  if (coarse.affinity < kSameShape) {
    calibration.warnings.push_back(
        fmt::format("The coarse mesh has no mode of the shape of eigenmode {}; its mode {} comes "
                    "nearest (cosine {:.2f}): choose finer cells.",
                    calibration.mode.mode + 1,
                    coarse.mode + 1,
                    coarse.affinity));
  }
}

/// Of the fundamental's mode, on the hex20 mesh that the ladder names for it; of a part from a mesh
/// file on the finest that was made of it.
ModulusSensitivities sensitivities_of(const Rig& rig, const Calibration& calibration) {
  const MeshLadder& ladder = calibration.ladder;
  if (rig.meshing.file)
    return modulus_sensitivities(rig, ladder.reference.back(), calibration.mode.mode);
  const double dx_m = ladder.sensitivity_dx_m();
  int mode = calibration.mode.mode;
  for (const MeshRung& rung : ladder.reference) {
    if (rung.mesh.kind != ElementKind::Hex20 || rung.mesh.requested_dx_m != dx_m) continue;
    mode = follow_mode(ladder.reference.back(), calibration.mode.mode, rung).mode;
  }
  return modulus_sensitivities(rig, dx_m, mode);
}

/// Samples a second: by the usual distance of two.
double rate_of(const Trace& trace) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < trace.num_samples(); ++i)
    steps.push_back(trace.time_s[i] - trace.time_s[i - 1]);
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return 1.0 / *middle;
}

void warn_about_aliases(const Calibration& calibration,
                        const RigMaterial& material,
                        std::vector<std::string>& warnings) {
  const Eigenmodes& mesh = calibration.ladder.reference.back().modes;  // at E = 1 Pa
  AliasQuestion question;
  question.modes = calibration.inversion.modes;
  question.rate_hz = rate_of(calibration.repeats.front().trace);
  question.mode = calibration.mode.mode;
  const double stretch =
      calibration.fundamental.natural_frequency_hz() / mesh.natural_frequency_hz(question.mode);
  for (int i = 0; i < mesh.count(); ++i)
    question.mesh_hz.push_back(stretch * mesh.natural_frequency_hz(i));
  if (material.reported_youngs_modulus_pa) {
    question.expected_hz =
        mesh.natural_frequency_hz(question.mode) * std::sqrt(*material.reported_youngs_modulus_pa);
  }
  const std::vector<std::string> found = alias_warnings(question);
  warnings.insert(warnings.end(), found.begin(), found.end());
}

/// E_n, b and, in E_n's ratio, E as the nonlinear simulation finds them.
void refine(const Rig& rig, const CalibrationOptions& options, Calibration& calibration) {
  std::vector<RefinedRecording> recordings;
  for (const Repeat& repeat : calibration.repeats)
    recordings.push_back({&repeat.trace, repeat.columns.front(), &repeat.inversion});
  RefineMaterialOptions refinement;
  refinement.progress = options.progress;
  Material& material = calibration.material;
  calibration.refined = refine_material(
      rig, calibration.ladder.coarse, material, recordings, calibration.coarse_mode, refinement);
  const RefinedMaterial& refined = *calibration.refined;
  if (refined.usable()) {
    detail::take_refinement(refined, material);
  } else {
    (refined.agrees ? calibration.remarks : calibration.warnings).push_back(refined.message);
  }
}

/// A release is a repeat of its own; the film stays with the first.
std::vector<Repeat> cut_recordings(const std::vector<Repeat>& recordings,
                                   const InversionOptions& options) {
  std::vector<Repeat> out;
  for (const Repeat& recording : recordings) {
    bool first = true;
    for (Trace& part : cut_at_releases(recording.trace, recording.columns, options)) {
      Repeat& repeat = out.emplace_back();
      repeat.file = recording.file;
      if (std::exchange(first, false)) repeat.film = recording.film;
      repeat.trace = std::move(part);
      repeat.columns = recording.columns;
    }
  }
  return out;
}

/// From the traces on, films and trace files go the same way.
Calibration calibrate_repeats(const Rig& rig,
                              std::vector<Repeat> repeats,
                              CalibrationOptions options) {
  const RigMaterial& unknown = unknown_material(rig);
  Calibration calibration;
  for (Repeat& repeat : repeats) {
    repeat.columns = detail::columns_to_invert(rig, repeat.trace, repeat.file, options.columns);
    if (options.refine) check_refinable(rig, repeat.columns.front());
  }
  if (options.each_release) {
    const std::size_t num_recordings = repeats.size();
    repeats = cut_recordings(repeats, options.inversion);
    calibration.remarks.push_back(
        fmt::format("{} release{} in {} recording{}, each taken for a repeat.",
                    repeats.size(),
                    repeats.size() == 1 ? "" : "s",
                    num_recordings,
                    num_recordings == 1 ? "" : "s"));
    options.inversion.start_s.reset();  // the parts are cut already
    options.inversion.end_s.reset();
  }
  for (Repeat& repeat : repeats) {
    invert_repeat(repeat, options);
    if (repeats.size() == 1) skip_creeping_overtones(repeat, options, calibration);
    const InversionResult& inversion = repeat.inversion;
    append(calibration.remarks, inversion.remarks);
    append(calibration.warnings, inversion.notes);
  }
  calibration.repeats = std::move(repeats);
  calibration.inversion = invert_jointly(calibration.repeats, options);
  calibration.fundamental = widened_fundamental(rig, calibration, options);
  calibration.target = damped_target(calibration.fundamental);

  LadderOptions ladder = options.ladder;
  ladder.progress = options.progress;
  calibration.ladder = build_mesh_ladder(rig, ladder);
  const auto& notes = calibration.ladder.notes;
  calibration.warnings.insert(calibration.warnings.end(), notes.begin(), notes.end());
  find_mode(rig, unknown, options, calibration);
  warn_about_aliases(calibration, unknown, calibration.warnings);

  calibration.sensitivities = sensitivities_of(rig, calibration);
  calibration.material = detail::material_of(rig, unknown, calibration);
  if (options.refine) refine(rig, options, calibration);
  if (options.validate) {
    const Repeat& first = calibration.repeats.front();
    const bool refined = calibration.refined && calibration.refined->usable();
    const FollowedStart start =
        refined ? calibration.refined->recordings.front().start : FollowedStart{};
    calibration.validation = validate_against_trace(rig,
                                                    calibration.ladder.coarse,
                                                    calibration.material,
                                                    first.trace,
                                                    first.columns.front(),
                                                    first.inversion,
                                                    options.progress,
                                                    calibration.coarse_mode,
                                                    {},
                                                    start);
    calibration.material.validation = calibration.validation->figures;
    if (!calibration.validation->run.usable())
      calibration.warnings.push_back(calibration.validation->run.message);
  }
  calibration.material.provenance = detail::provenance_of(rig, calibration.repeats, options);
  return calibration;
}

}  // namespace

RepeatedInversion inversion_of_repeats(const Calibration& calibration) {
  std::vector<InversionResult> alone;
  for (const Repeat& repeat : calibration.repeats) alone.push_back(repeat.inversion);
  return relate_repeats(calibration.inversion, std::move(alone));
}

Calibration calibrate_from_films(const Rig& rig,
                                 const std::vector<fs::path>& films,
                                 const CalibrationOptions& options) {
  if (films.empty()) throw InputError("no film is given, must be one or more");
  if (!options.overlays.empty() && options.overlays.size() != films.size()) {
    throw InputError(fmt::format(
        "{} overlays for {} films, must be one each", options.overlays.size(), films.size()));
  }
  std::ignore = unknown_material(rig);  // refused before the films are read
  std::vector<Repeat> repeats;
  std::vector<std::string> warnings;
  std::vector<std::string> remarks;
  const auto append = [](std::vector<std::string>& to, const std::vector<std::string>& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  for (std::size_t i = 0; i < films.size(); ++i) {
    TrackOptions track = options.track;
    track.progress = options.progress;
    track.overlay = options.overlays.empty() ? fs::path() : options.overlays[i];
    Repeat repeat;
    repeat.file = films[i];
    repeat.film = track_markers(rig, films[i], track);
    repeat.trace = repeat.film->trace;
    if (options.on_tracked) options.on_tracked(films[i], *repeat.film);
    append(warnings, sentences_of(repeat.film->notes, Severity::Warning));
    append(remarks, sentences_of(repeat.film->notes, Severity::Remark));
    repeats.push_back(std::move(repeat));
  }
  Calibration calibration = calibrate_repeats(rig, std::move(repeats), options);
  append(warnings, calibration.warnings);
  append(remarks, calibration.remarks);
  calibration.warnings = std::move(warnings);
  calibration.remarks = std::move(remarks);
  return calibration;
}

Calibration calibrate_from_traces(const Rig& rig,
                                  const std::vector<fs::path>& traces,
                                  const CalibrationOptions& options) {
  if (traces.empty()) throw InputError("no trace is given, must be one or more");
  std::vector<Repeat> repeats;
  for (const fs::path& file : traces) {
    Repeat repeat;
    repeat.file = file;
    repeat.trace = read_trace_csv(file, options.time_column);
    repeats.push_back(std::move(repeat));
  }
  return calibrate_repeats(rig, std::move(repeats), options);
}

}  // namespace twang
