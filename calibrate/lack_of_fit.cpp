// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/lack_of_fit.hpp"

#include "core/constants.hpp"
#include "core/units.hpp"
#include "rigs/observable.hpp"

#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace twang {
namespace {

constexpr double kEnvelopeToDecay = 4.0;

/// Root mean square of a marker's sigmas in the window that was inverted; nothing without any [mm].
std::optional<double> rms_sigma_mm(const Trace& trace,
                                   const std::string& marker,
                                   const InversionResult& inversion) {
  const Channel* sigma = trace.find(marker + ".sigma_mm");
  if (sigma == nullptr) return std::nullopt;
  double square = 0.0;
  double count = 0.0;
  for (std::size_t n = 0; n < trace.time_s.size(); ++n) {
    const bool inside =
        trace.time_s[n] >= inversion.time_origin_s && trace.time_s[n] <= inversion.time_end_s;
    if (!inside || !std::isfinite(sigma->values[n])) continue;
    square += sigma->values[n] * sigma->values[n];
    count += 1.0;
  }
  if (count == 0.0) return std::nullopt;
  return std::sqrt(square / count);
}

/// One sigma of a sample of a column, in the column's unit; nothing if it is not known.
std::optional<double> sigma_of_column(const Rig& rig,
                                      const Trace& trace,
                                      const std::string& column,
                                      const InversionResult& inversion) {
  const auto dot = column.rfind('.');
  if (dot != std::string::npos) return rms_sigma_mm(trace, column.substr(0, dot), inversion);
  if (!rig.observable || column != observable_column(rig.observable->kind)) return std::nullopt;
  const ObservableDefinition& definition = *rig.observable;
  double sigma_mm = 0.0;
  for (const std::string& id : definition.markers) {
    const auto of_marker = rms_sigma_mm(trace, id, inversion);
    if (!of_marker) return std::nullopt;
    sigma_mm = std::hypot(sigma_mm, *of_marker);
  }
  if (definition.kind == ObservableKind::Displacement) return sigma_mm;
  const Marker* a = rig.find_marker(definition.markers.front());
  const Marker* b = rig.find_marker(definition.markers.back());
  if (a == nullptr || b == nullptr) return std::nullopt;
  return sigma_mm * kMetresPerMillimetre / (b->position - a->position).norm();
}

}  // namespace

LackOfFit lack_of_fit(const Rig& rig, const Trace& trace, const InversionResult& inversion) {
  if (!inversion.usable()) return {};
  const DampedSinusoid& mode = inversion.modes.front();
  for (const SinusoidInChannel& channel : mode.channels) {
    const auto sigma = sigma_of_column(rig, trace, channel.channel, inversion);
    if (!sigma || !(channel.amplitude > 0.0)) continue;
    const double square = inversion.residual_rms * inversion.residual_rms - *sigma * *sigma;
    const double c = std::sqrt(std::max(0.0, square));
    const double spread = kEnvelopeToDecay * c / channel.amplitude * mode.decay_per_s;
    return {spread / kTwoPi, spread};
  }
  return {};
}

}  // namespace twang
