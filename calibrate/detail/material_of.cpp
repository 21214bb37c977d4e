// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/detail/material_of.hpp"

#include "calibrate/repeat_scatter.hpp"
#include "coarsen/follow_mode.hpp"
#include "coarsen/prestress.hpp"
#include "core/sha256.hpp"
#include "core/units.hpp"
#include "core/version.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <string>

namespace twang::detail {
namespace {

namespace fs = std::filesystem;

/// Of the mode that all share: in one recording another may be the strongest.
double between_repeats(const Calibration& calibration) {
  const RepeatedInversion repeated = inversion_of_repeats(calibration);
  std::vector<double> lambdas;
  for (std::size_t n = 0; n < repeated.alone.size(); ++n) {
    if (const DampedSinusoid* mode = repeated.mode_alone(n))
      lambdas.push_back(mode->lambda_per_s2());
  }
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

/// Takes the round-off out of a cell size that was found as a difference of coordinates [m].
double rounded_to_picometres(double length_m) { return std::round(length_m * 1e12) / 1e12; }

}  // namespace

Material material_of(const Rig& rig, const RigMaterial& unknown, const Calibration& calibration) {
  const DampedSinusoid& mode = calibration.fundamental;
  const DampedTarget& target = calibration.target;
  const MeshRung& coarse = calibration.ladder.coarse;
  Material material;
  material.material = unknown.name;
  const ElasticMaterial elastic = {1.0, unknown.poissons_ratio, unknown.density_kg_m3};
  const MeshRung& light = calibration.ladder.reference.front();
  const int light_mode =
      follow_mode(calibration.ladder.reference.back(), calibration.mode.mode, light).mode;
  material.youngs_modulus_identified_pa = modulus_for_target(
      rig, light, elastic, calibration.limit.lambda_per_s2, target.lambda_per_s2, light_mode);
  material.youngs_modulus_numerical_pa =
      modulus_for_target(rig,
                         coarse,
                         elastic,
                         coarse.modes.lambda_per_s2[calibration.coarse_mode],
                         target.lambda_per_s2,
                         calibration.coarse_mode);
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
                                        calibration.limit.relative_sigma,
                                        between_repeats(calibration),
                                        rig.tolerance,
                                        calibration.sensitivities);
  material.youngs_modulus_identified_sigma_pa =
      material.youngs_modulus_identified_pa * material.uncertainty.total();
  material.specimen = rig.specimen;
  material.eigenmode = calibration.mode.mode + 1;
  material.eigenmode_reason = calibration.mode.reason;
  return material;
}

void take_refinement(const RefinedMaterial& refined, Material& material) {
  material.youngs_modulus_numerical_pa = refined.youngs_modulus_numerical_pa;
  material.youngs_modulus_identified_pa *= 1.0 + refined.change.modulus_change_rel;
  material.uncertainty.statistical = refined.modulus_sigma_rel;
  material.youngs_modulus_identified_sigma_pa =
      material.youngs_modulus_identified_pa * material.uncertainty.total();
  material.damping_stiffness_b_s = refined.damping_stiffness_b_s;
  material.damping_stiffness_b_sigma_s = refined.damping_stiffness_b_s * refined.damping_sigma_rel;
  material.tan_delta = material.damping_stiffness_b_s * std::sqrt(material.lambda_per_s2);
  material.refinement = refined.change;
}

Provenance provenance_of(const Rig& rig,
                         const std::vector<Repeat>& repeats,
                         const CalibrationOptions& options) {
  Provenance provenance;
  provenance.twang_version = kVersion;
  provenance.date = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  provenance.inputs.push_back({rig.file.filename().string(), rig.sha256});
  if (rig.meshing.file) {
    const fs::path& mesh = rig.meshing.file->file;
    provenance.inputs.push_back({mesh.filename().string(), sha256_of_file(mesh)});
  }
  for (std::size_t i = 0; i < repeats.size(); ++i) {
    const fs::path& file = repeats[i].file;
    if (i > 0 && file == repeats[i - 1].file) continue;  // another release of the same
    provenance.inputs.push_back({file.filename().string(), sha256_of_file(file)});
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
  if (options.mode) used["mode"] = fmt::format("{}", *options.mode + 1);
  if (options.each_release) used["each_release"] = "true";
  if (options.refine) used["refine"] = "true";
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

}  // namespace twang::detail
