// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/rheology.hpp"

#include "core/damped_sinusoid.hpp"
#include "core/error.hpp"
#include "core/text.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

/// Highest over lowest frequency below which no slope is asked for.
constexpr double kLeastSpan = 1.05;
/// Sigmas beyond which two things are called different.
constexpr double kDifferent = 2.0;

FrequencyPoint point_of(const NamedMaterial& named, const RheologyOptions& options) {
  const Material& material = named.material;
  const UncertaintyBudget& budget = material.uncertainty;
  FrequencyPoint point;
  point.name = named.name;
  point.frequency_hz = material.frequency_hz;
  point.youngs_modulus_pa = material.youngs_modulus_identified_pa;
  point.youngs_modulus_sigma_pa = material.youngs_modulus_identified_sigma_pa;
  UncertaintyBudget own;
  own.statistical = budget.statistical;
  own.repeats = budget.repeats;
  own.mesh = budget.mesh;
  if (!options.same_part) own.dimension = budget.dimension;
  point.compared_sigma_pa = point.youngs_modulus_pa * own.total();
  DampedSinusoid sinusoid;
  sinusoid.frequency_hz = material.frequency_hz;
  sinusoid.frequency_sigma_hz = material.frequency_sigma_hz;
  sinusoid.decay_per_s = material.decay_per_s;
  sinusoid.decay_sigma_per_s = material.decay_sigma_per_s;
  point.tan_delta = material.tan_delta;
  point.tan_delta_sigma = 2.0 * sinusoid.damping_ratio_sigma();  // tan delta = b sqrt(lambda)
  point.damping_stiffness_b_s = material.damping_stiffness_b_s;
  point.damping_stiffness_b_sigma_s = material.damping_stiffness_b_sigma_s;
  point.eigenmode = material.eigenmode;
  return point;
}

/// Through (f, y); without all sigmas every point counts alike and their scatter is the sigma.
PowerLaw fit_power_law(const std::vector<FrequencyPoint>& points,
                       double FrequencyPoint::*value,
                       double FrequencyPoint::*sigma) {
  PowerLaw law;
  double sum = 0.0;
  for (const FrequencyPoint& point : points) sum += std::log(point.frequency_hz);
  law.reference_hz = std::exp(sum / static_cast<double>(points.size()));
  const bool weighted = std::all_of(points.begin(), points.end(), [&](const FrequencyPoint& point) {
    return std::isfinite(point.*sigma) && point.*sigma > 0.0;
  });
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  const auto weight_of = [&](const FrequencyPoint& point) {
    return weighted ? std::pow(point.*value / point.*sigma, 2) : 1.0;
  };
  for (const FrequencyPoint& point : points) {
    const Eigen::Vector2d row(1.0, std::log(point.frequency_hz / law.reference_hz));
    normal += weight_of(point) * row * row.transpose();
    right += weight_of(point) * std::log(point.*value) * row;
  }
  const Eigen::Matrix2d covariance = normal.inverse();
  const Eigen::Vector2d x = covariance * right;
  law.value = std::exp(x[0]);
  law.exponent = x[1];
  law.degrees_of_freedom = static_cast<int>(points.size()) - 2;
  for (const FrequencyPoint& point : points) {
    law.chi_square +=
        weight_of(point) * std::pow(std::log(point.*value / law.at(point.frequency_hz)), 2);
  }
  const double scatter =
      law.degrees_of_freedom > 0 ? law.chi_square / law.degrees_of_freedom : kNaN;
  double widening = scatter;  // of the variance
  if (weighted) widening = std::isfinite(scatter) ? std::max(1.0, scatter) : 1.0;
  law.exponent_sigma = std::sqrt(covariance(1, 1) * widening);
  return law;
}

std::string exponent_text(const PowerLaw& law) {
  return text_with_sigma(law.exponent, law.exponent_sigma);
}

std::string modulus_sentence(const FrequencyDependence& found) {
  const PowerLaw& law = *found.modulus;
  const std::string range = fmt::format("{} to {} Hz",
                                        rounded_text(found.points.front().frequency_hz, 4),
                                        rounded_text(found.points.back().frequency_hz, 4));
  if (!std::isfinite(law.exponent_sigma)) {
    return fmt::format("From {} E goes as f^n with n = {}; its uncertainty is not known.",
                       range,
                       exponent_text(law));
  }
  const double sigmas = std::abs(law.exponent) / law.exponent_sigma;
  return found.changes
             ? fmt::format(
                   "E changes with frequency: from {} it goes as f^n with n = {}, {} sigmas "
                   "from a constant.",
                   range,
                   exponent_text(law),
                   rounded_text(sigmas, 2))
             : fmt::format(
                   "E does not change with frequency beyond its uncertainty: from {} it "
                   "goes as f^n with n = {}.",
                   range,
                   exponent_text(law));
}

std::string loss_sentence(const FrequencyDependence& found) {
  const double measured = found.tan_delta->value;
  double variance = 0.0;  // of the mean of ln tan delta
  for (const FrequencyPoint& point : found.points) {
    variance += std::pow(point.tan_delta_sigma / point.tan_delta, 2);
  }
  const double sigma = measured * std::sqrt(variance) / static_cast<double>(found.points.size());
  std::string text = fmt::format(
      "A material with E ~ f^n has tan delta = tan(n pi / 2) = {}; measured is {} at {} Hz",
      text_with_sigma(found.tan_delta_of_exponent, found.tan_delta_of_exponent_sigma),
      text_with_sigma(measured, sigma),
      rounded_text(found.tan_delta->reference_hz, 4));
  const double both = std::hypot(sigma, found.tan_delta_of_exponent_sigma);
  if (!std::isfinite(both)) return text + ".";
  return std::abs(measured - found.tan_delta_of_exponent) <= kDifferent * both
             ? text + ": the two agree."
             : text +
                   ": the two do not agree, so something else than the material's creep damps "
                   "it, or E was compared across more than frequency.";
}

std::string damping_sentence(const FrequencyDependence& found) {
  return fmt::format(
      "b goes as f^m with m = {}, tan delta with {}: one b for all frequencies would be m = 0, one "
      "tan delta m = -1.",
      exponent_text(*found.damping),
      exponent_text(*found.tan_delta));
}

void refuse_unlike(const std::vector<NamedMaterial>& calibrations) {
  if (calibrations.size() < 2) {
    throw InputError(
        fmt::format("{} calibration is given, must be two or more at different frequencies",
                    calibrations.size()));
  }
  const NamedMaterial& first = calibrations.front();
  for (const NamedMaterial& named : calibrations) {
    if (named.material.material != first.material.material) {
      throw InputError(fmt::format("{}: is of material \"{}\", must be \"{}\" as {} is",
                                   named.name,
                                   named.material.material,
                                   first.material.material,
                                   first.name));
    }
    if (!(named.material.frequency_hz > 0.0) || !(named.material.tan_delta > 0.0)) {
      throw InputError(fmt::format("{}: frequency_hz is {} and tan_delta {}, both must be > 0",
                                   named.name,
                                   named.material.frequency_hz,
                                   named.material.tan_delta));
    }
  }
}

void note_differences(const std::vector<NamedMaterial>& calibrations, FrequencyDependence& found) {
  constexpr double kSame = 1e-3;
  const NamedMaterial& first = calibrations.front();
  for (const NamedMaterial& named : calibrations) {
    const Material& material = named.material;
    if (std::abs(material.density_kg_m3 / first.material.density_kg_m3 - 1.0) > kSame) {
      found.notes.push_back(
          fmt::format("{} takes the density for {} kg/m³, {} for {}: E goes with it.",
                      named.name,
                      rounded_text(material.density_kg_m3, 5),
                      first.name,
                      rounded_text(first.material.density_kg_m3, 5)));
    }
    if (std::abs(material.poissons_ratio - first.material.poissons_ratio) > kSame) {
      found.notes.push_back(fmt::format("{} takes Poisson's ratio for {}, {} for {}.",
                                        named.name,
                                        material.poissons_ratio,
                                        first.name,
                                        first.material.poissons_ratio));
    }
  }
}

}  // namespace

double PowerLaw::at(double frequency_hz) const {
  return value * std::pow(frequency_hz / reference_hz, exponent);
}

FrequencyDependence frequency_dependence(const std::vector<NamedMaterial>& calibrations,
                                         const RheologyOptions& options) {
  refuse_unlike(calibrations);
  FrequencyDependence found;
  found.material = calibrations.front().material.material;
  for (const NamedMaterial& named : calibrations) found.points.push_back(point_of(named, options));
  std::stable_sort(found.points.begin(), found.points.end(), [](const auto& a, const auto& b) {
    return a.frequency_hz < b.frequency_hz;
  });
  note_differences(calibrations, found);
  const double lowest = found.points.front().frequency_hz;
  const double highest = found.points.back().frequency_hz;
  if (highest < kLeastSpan * lowest) {
    found.sentences.push_back(fmt::format(
        "The frequencies, {} to {} Hz, lie too close together to tell how E depends on them.",
        rounded_text(lowest, 4),
        rounded_text(highest, 4)));
    return found;
  }
  found.modulus = fit_power_law(
      found.points, &FrequencyPoint::youngs_modulus_pa, &FrequencyPoint::compared_sigma_pa);
  found.tan_delta =
      fit_power_law(found.points, &FrequencyPoint::tan_delta, &FrequencyPoint::tan_delta_sigma);
  found.damping = fit_power_law(found.points,
                                &FrequencyPoint::damping_stiffness_b_s,
                                &FrequencyPoint::damping_stiffness_b_sigma_s);
  const PowerLaw& law = *found.modulus;
  found.changes = std::abs(law.exponent) > kDifferent * law.exponent_sigma;
  found.tan_delta_of_exponent = std::tan(0.5 * kPi * law.exponent);
  found.tan_delta_of_exponent_sigma =
      0.5 * kPi * law.exponent_sigma * (1.0 + std::pow(found.tan_delta_of_exponent, 2));
  found.sentences = {modulus_sentence(found), loss_sentence(found), damping_sentence(found)};
  return found;
}

}  // namespace twang
