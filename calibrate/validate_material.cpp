// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/validate_material.hpp"

#include "calibrate/simulated_observable.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "rigs/observable.hpp"
#include "simulate/numerical_modulus.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <complex>

namespace twang {
namespace {

constexpr int kNumModes = 10;  // of the mesh, among which the signal's sinusoids find their shapes

std::string found_column(const Rig& rig, const Trace& trace, const std::string& wanted) {
  if (!wanted.empty()) {
    if (trace.find(wanted) == nullptr)
      throw InputError(fmt::format("the trace has no column \"{}\"", wanted));
    return wanted;
  }
  if (rig.observable) {
    std::string column = observable_column(rig.observable->kind);
    if (trace.find(column) != nullptr) return column;
  }
  const std::vector<std::string> columns = default_columns(trace);
  if (columns.empty()) throw InputError("the trace has no column to compare with");
  return columns.front();
}

std::string column_of(const Rig& rig, const Trace& trace, const std::string& wanted) {
  std::string column = found_column(rig, trace, wanted);
  if (const std::string fault = column_fault(rig, column); !fault.empty())
    throw InputError(fmt::format("the trace's column {} {}", column, fault));
  return column;
}

/// The rig's mesh for the material, at E = 1 Pa.
MeshRung rung_for(const Rig& rig,
                  const Material& material,
                  const MaterialValidationOptions& options) {
  Rig unit_rig = as_solids(rig);  // E_n belongs to voxels
  for (RigMaterial& of_rig : unit_rig.materials) {
    of_rig.youngs_modulus_pa.reset();
    of_rig.poissons_ratio = material.poissons_ratio;
    of_rig.density_kg_m3 = material.density_kg_m3;
  }
  const double dx_m = options.dx_m.value_or(material.numerical_dx_mm * kMetresPerMillimetre);
  const ElementKind element =
      options.element ? *options.element : element_kind_from(material.numerical_element);
  MeshRung rung = compute_rung(unit_rig, dx_m, element, kNumModes, options.progress);
  if (options.identified) return rung;
  const std::string fault = numerical_modulus_fault(material, rung.mesh);
  if (!fault.empty())
    throw InputError(fmt::format("the numerical modulus {} (or --modulus identified)", fault));
  return rung;
}

/// Phase of the sinusoid of known frequency that fits samples best, its offset free [rad].
double fitted_phase(const std::vector<double>& time_s,
                    const std::vector<double>& y,
                    std::size_t begin,
                    std::size_t end,
                    double frequency_hz) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t i = begin; i < end; ++i) {
    const double angle = kTwoPi * frequency_hz * time_s[i];
    const Eigen::Vector3d row(std::cos(angle), std::sin(angle), 1.0);
    normal += row * row.transpose();
    right += row * y[i];
  }
  const Eigen::Vector3d fit = normal.inverse() * right;
  return std::atan2(fit[1], fit[0]);
}

}  // namespace

bool FigureOfMerit::met() const { return std::abs(value) <= bound; }

std::vector<FigureOfMerit> MaterialValidation::figures() const {
  const ValidationFigures& f = validation.figures;
  return {{"rms", f.rms_rel, 0.03},
          {"frequency", f.frequency_error_rel, 0.005},
          {"decay", f.decay_error_rel, 0.05}};
}

double phase_drift(const std::vector<double>& time_s,
                   const std::vector<double>& a,
                   const std::vector<double>& b,
                   double frequency_hz) {
  constexpr std::size_t kFewest = 6;  // samples, for three unknowns
  const double period_s = 1.0 / frequency_hz;
  std::size_t count = 0;  // of samples in a period, or as many periods as it takes
  while (count < time_s.size() && (count < kFewest || time_s[count] - time_s.front() < period_s))
    ++count;
  if (2 * count > time_s.size()) return kNaN;
  const auto lead = [&](std::size_t begin, std::size_t end) {
    // cos(w t - p): a larger p is later
    return fitted_phase(time_s, a, begin, end, frequency_hz) -
           fitted_phase(time_s, b, begin, end, frequency_hz);
  };
  return std::remainder(lead(time_s.size() - count, time_s.size()) - lead(0, count), kTwoPi);
}

MaterialValidation validate_material(const Rig& rig,
                                     const Material& material,
                                     const Trace& trace,
                                     const MaterialValidationOptions& options) {
  const double modulus = options.identified ? material.youngs_modulus_identified_pa
                                            : material.youngs_modulus_numerical_pa;
  if (!(modulus > 0.0) || !(material.damping_stiffness_b_s >= 0.0))
    throw InputError(fmt::format("the material lacks its {} modulus or damping_stiffness_b_s",
                                 options.identified ? "identified" : "numerical"));
  MaterialValidation result;
  result.column = column_of(rig, trace, options.column);
  result.inversion = invert_harmonics(trace, {result.column}, options.inversion);
  if (!result.inversion.usable())
    throw NumericalFailure(
        fmt::format("no vibration was found in {}: {}", result.column, result.inversion.message));
  const MeshRung rung = rung_for(rig, material, options);
  result.num_elements = rung.mesh.num_elements();
  result.dx_m = rung.mesh.requested_dx_m;
  result.element = rung.mesh.kind;
  Material used = material;
  used.youngs_modulus_numerical_pa = modulus;
  result.validation = validate_against_trace(rig,
                                             rung,
                                             used,
                                             trace,
                                             result.column,
                                             result.inversion,
                                             options.progress,
                                             0,
                                             options.on_state);
  if (!result.validation.run.usable()) throw NumericalFailure(result.validation.run.message);
  result.phase_drift_rad = phase_drift(result.validation.time_s,
                                       result.validation.tracked,
                                       result.validation.simulated,
                                       result.inversion.modes.front().frequency_hz);
  return result;
}

std::string validation_to_json(const MaterialValidation& result) {
  const Validation& v = result.validation;
  const auto sinusoid = [](const DampedPole& pole) {
    return nlohmann::ordered_json{{"frequency_hz", pole.frequency_hz},
                                  {"decay_per_s", pole.decay_per_s}};
  };
  nlohmann::ordered_json json = {{"format", "twang-validation/1"},
                                 {"column", result.column},
                                 {"element", std::string(to_string(result.element))},
                                 {"dx_mm", result.dx_m * kMillimetresPerMetre},
                                 {"elements", result.num_elements},
                                 {"tracked", sinusoid(v.tracked_sinusoid)},
                                 {"simulated", sinusoid(v.simulated_sinusoid)},
                                 {"rms_rel", v.figures.rms_rel},
                                 {"frequency_error_rel", v.figures.frequency_error_rel},
                                 {"decay_error_rel", v.figures.decay_error_rel},
                                 {"phase_drift_rad", result.phase_drift_rad},
                                 {"steps", v.run.steps},
                                 {"step_s", v.step_s},
                                 {"wall_s", v.run.wall_s}};
  bool all = true;
  for (const FigureOfMerit& figure : result.figures()) {
    json["bounds"][figure.name] = {{"bound", figure.bound}, {"met", figure.met()}};
    all = all && figure.met();
  }
  json["all_met"] = all;
  return json.dump(2) + "\n";
}

}  // namespace twang
