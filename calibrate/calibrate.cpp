// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/calibrate.hpp"

#include "calibrate/alias_check.hpp"
#include "calibrate/lack_of_fit.hpp"
#include "calibrate/repeat_scatter.hpp"
#include "calibrate/window_stability.hpp"
#include "coarsen/prestress.hpp"
#include "core/error.hpp"
#include "core/sha256.hpp"
#include "core/trace_file.hpp"
#include "core/units.hpp"
#include "core/version.hpp"
#include "harmonic_inversion/decay_checks.hpp"
#include "rigs/observable.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

namespace twang {
namespace {

namespace fs = std::filesystem;

/// The one material whose modulus is to be found.
const RigMaterial& unknown_material(const Rig& rig) {
  const RigMaterial* unknown = nullptr;
  for (const RigMaterial& material : rig.materials) {
    const bool used = std::any_of(rig.parts.begin(), rig.parts.end(), [&](const PartSolid& solid) {
      return solid.material == material.name;
    });
    if (!used) continue;
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

std::vector<std::string> columns_to_invert(const Rig& rig,
                                           const Repeat& repeat,
                                           const CalibrationOptions& options) {
  if (!options.columns.empty()) {
    for (const std::string& column : options.columns) {
      if (repeat.trace.find(column) == nullptr) {
        throw InputError(fmt::format("{}: has no column '{}'", repeat.file.string(), column));
      }
    }
    return options.columns;
  }
  if (rig.observable) {
    const std::string column = observable_column(rig.observable->kind);
    if (repeat.trace.find(column) != nullptr) return {column};
  }
  return default_columns(repeat.trace);
}

void invert_repeat(const Rig& rig, Repeat& repeat, const CalibrationOptions& options) {
  repeat.columns = columns_to_invert(rig, repeat, options);
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

double between_repeats(const std::vector<Repeat>& repeats) {
  std::vector<double> lambdas;
  for (const Repeat& repeat : repeats)
    lambdas.push_back(repeat.inversion.modes.front().lambda_per_s2());
  return relative_standard_error(lambdas);
}

/// Smallest and largest amplitude of the strongest sinusoid in the windows used.
std::array<double, 2> amplitude_range(const std::vector<Repeat>& repeats) {
  std::array<double, 2> range = {kInfinity, 0.0};
  for (const Repeat& repeat : repeats) {
    const DampedSinusoid& mode = repeat.inversion.modes.front();
    const double duration_s = repeat.inversion.time_end_s - repeat.inversion.time_origin_s;
    for (const SinusoidInChannel& channel : mode.channels) {
      range[0] = std::min(range[0], channel.amplitude * std::exp(-mode.decay_per_s * duration_s));
      range[1] = std::max(range[1], channel.amplitude);
    }
  }
  return range;
}

std::string unit_of_column(const std::string& column) {
  for (const char* unit : {"mm", "rad", "px", "deg", "m"}) {
    if (column.ends_with(std::string("_") + unit)) return unit;
  }
  return "";
}

/// Two sinusoids whose frequencies the mesh puts elsewhere are told to the user, never acted on.
void warn_about_overtones(const InversionResult& inversion,
                          const MeshRung& finest,
                          std::vector<std::string>& warnings) {
  const double first_hz = finest.modes.natural_frequency_hz(0);
  const DampedSinusoid& fundamental = inversion.modes.front();
  for (const DampedSinusoid& mode : inversion.modes) {
    if (mode.natural_frequency_hz() < 0.8 * fundamental.natural_frequency_hz()) {
      warnings.push_back(
          fmt::format("A sinusoid at {:.2f} Hz lies below the strongest one at {:.2f} Hz, which is "
                      "taken for the first eigenmode "
                      "(mesh ratio of the second to the first: {:.2f}).",
                      mode.frequency_hz,
                      fundamental.frequency_hz,
                      finest.modes.natural_frequency_hz(1) / first_hz));
    }
  }
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
  const double stretch =
      calibration.fundamental.natural_frequency_hz() / mesh.natural_frequency_hz(0);
  for (int i = 0; i < mesh.count(); ++i)
    question.mesh_hz.push_back(stretch * mesh.natural_frequency_hz(i));
  if (material.reported_youngs_modulus_pa) {
    question.expected_first_hz =
        mesh.natural_frequency_hz(0) * std::sqrt(*material.reported_youngs_modulus_pa);
  }
  const std::vector<std::string> found = alias_warnings(question);
  warnings.insert(warnings.end(), found.begin(), found.end());
}

Provenance provenance_of(const Rig& rig,
                         const std::vector<Repeat>& repeats,
                         const CalibrationOptions& options) {
  Provenance provenance;
  provenance.twang_version = kVersion;
  provenance.date = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  provenance.inputs.push_back({rig.file.filename().string(), rig.sha256});
  for (const Repeat& repeat : repeats) {
    provenance.inputs.push_back({repeat.file.filename().string(), sha256_of_file(repeat.file)});
  }
  const fs::path& lens =
      options.track.lens.empty() && rig.camera ? rig.camera->lens : options.track.lens;
  if (!lens.empty() && repeats.front().film) {
    provenance.inputs.push_back({lens.filename().string(), sha256_of_file(lens)});
  }
  auto& used = provenance.options;
  std::string columns;
  for (const std::string& column : repeats.front().columns)
    columns += (columns.empty() ? "" : ",") + column;
  used["columns"] = columns;
  used["start_s"] = fmt::format("{}", repeats.front().inversion.time_origin_s);
  used["end_s"] = fmt::format("{}", repeats.front().inversion.time_end_s);
  if (options.track.capture_fps)
    used["capture_fps"] = fmt::format("{}", *options.track.capture_fps);
  if (options.inversion.band_hz) {
    used["band_hz"] =
        fmt::format("{} {}", options.inversion.band_hz->low_hz, options.inversion.band_hz->high_hz);
  }
  if (options.ladder.coarse_dx_m) {
    used["dx_mm"] = fmt::format("{}", *options.ladder.coarse_dx_m * kMillimetresPerMetre);
  }
  for (const auto& [id, start] : options.track.start_px) {
    used["marker " + id] = fmt::format("{},{}", start.x(), start.y());
  }
  return provenance;
}

/// Takes the round-off out of a cell size that was found as a difference of coordinates [m].
double rounded_to_picometres(double length_m) { return std::round(length_m * 1e12) / 1e12; }

Material material_from(const Rig& rig, const RigMaterial& unknown, const Calibration& calibration) {
  const DampedSinusoid& mode = calibration.fundamental;
  const DampedTarget& target = calibration.target;
  const MeshRung& coarse = calibration.ladder.coarse;
  Material material;
  material.material = unknown.name;
  const ElasticMaterial elastic = {1.0, unknown.poissons_ratio, unknown.density_kg_m3};
  material.youngs_modulus_identified_pa = modulus_for_target(rig,
                                                             calibration.ladder.reference.front(),
                                                             elastic,
                                                             calibration.ladder.limit.lambda_per_s2,
                                                             target.lambda_per_s2);
  material.youngs_modulus_numerical_pa =
      modulus_for_target(rig, coarse, elastic, coarse.modes.lambda_per_s2[0], target.lambda_per_s2);
  material.numerical_element = to_string(coarse.mesh.kind);
  material.numerical_dx_mm =
      rounded_to_picometres(coarse.mesh.requested_dx_m) * kMillimetresPerMetre;
  material.numerical_elements = coarse.mesh.num_elements();
  material.rig_sha256 = rig.sha256;
  material.damping_stiffness_b_s = target.damping_stiffness_b_s;
  material.damping_stiffness_b_sigma_s = target.damping_stiffness_b_sigma_s;
  material.poissons_ratio = unknown.poissons_ratio;
  material.density_kg_m3 = unknown.density_kg_m3;
  material.reported_youngs_modulus_pa = unknown.reported_youngs_modulus_pa;
  material.frequency_hz = mode.frequency_hz;
  material.frequency_sigma_hz = mode.frequency_sigma_hz;
  material.decay_per_s = mode.decay_per_s;
  material.decay_sigma_per_s = mode.decay_sigma_per_s;
  material.lambda_per_s2 = target.lambda_per_s2;
  material.tan_delta = target.damping_stiffness_b_s * std::sqrt(target.lambda_per_s2);
  material.amplitude_range = amplitude_range(calibration.repeats);
  material.amplitude_unit = unit_of_column(calibration.repeats.front().columns.front());
  material.uncertainty = modulus_budget(target,
                                        calibration.ladder.limit.relative_sigma,
                                        between_repeats(calibration.repeats),
                                        rig.tolerance,
                                        calibration.sensitivities);
  material.youngs_modulus_identified_sigma_pa =
      material.youngs_modulus_identified_pa * material.uncertainty.total();
  material.specimen = rig.specimen;
  return material;
}

/// From the traces on, films and trace files go the same way.
Calibration calibrate_repeats(const Rig& rig,
                              std::vector<Repeat> repeats,
                              const CalibrationOptions& options) {
  const RigMaterial& unknown = unknown_material(rig);
  Calibration calibration;
  for (Repeat& repeat : repeats) {
    invert_repeat(rig, repeat, options);
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
  warn_about_overtones(
      calibration.inversion, calibration.ladder.reference.back(), calibration.warnings);
  warn_about_aliases(calibration, unknown, calibration.warnings);

  const auto accurate = static_cast<std::size_t>(calibration.ladder.accurate_rung.value_or(0));
  calibration.sensitivities =
      modulus_sensitivities(rig, calibration.ladder.reference[accurate].mesh.requested_dx_m);
  calibration.material = material_from(rig, unknown, calibration);
  if (options.validate) {
    const Repeat& first = calibration.repeats.front();
    calibration.validation = validate_against_trace(rig,
                                                    calibration.ladder.coarse,
                                                    calibration.material,
                                                    first.trace,
                                                    first.columns.front(),
                                                    first.inversion,
                                                    options.progress);
    calibration.material.validation = calibration.validation->figures;
    if (!calibration.validation->run.usable())
      calibration.warnings.push_back(calibration.validation->run.message);
  }
  calibration.material.provenance = provenance_of(rig, calibration.repeats, options);
  return calibration;
}

}  // namespace

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
