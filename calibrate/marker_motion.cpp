// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/marker_motion.hpp"

#include "core/dense_algebra.hpp"
#include "core/units.hpp"

#include <fmt/format.h>

#include <cmath>

namespace twang {
namespace {

/// The samples of a channel within the window.
struct Samples {
  std::vector<double> tau_s;  // since the time origin
  std::vector<double> value;
};

Samples samples_of(const Trace& trace, const Channel& channel, const InversionResult& window) {
  Samples samples;
  const Channel* offset_s = trace.time_offset_of(channel.name);
  for (std::size_t i = 0; i < trace.num_samples(); ++i) {
    const double time = trace.time_s[i] + (offset_s == nullptr ? 0.0 : offset_s->values[i]);
    if (!(time >= window.time_origin_s && time <= window.time_end_s)) continue;
    if (!std::isfinite(channel.values[i])) continue;
    samples.tau_s.push_back(time - window.time_origin_s);
    samples.value.push_back(channel.values[i]);
  }
  return samples;
}

/// Offset, drift, and two columns a sinusoid.
Eigen::MatrixXd columns_of(const Samples& samples, const std::vector<DampedSinusoid>& sinusoids) {
  const auto rows = static_cast<Eigen::Index>(samples.tau_s.size());
  Eigen::MatrixXd A(rows, 2 + 2 * static_cast<Eigen::Index>(sinusoids.size()));
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double tau = samples.tau_s[static_cast<std::size_t>(i)];
    A(i, 0) = 1.0;
    A(i, 1) = tau;
    Eigen::Index column = 2;
    for (const DampedSinusoid& sinusoid : sinusoids) {
      const double envelope = std::exp(-sinusoid.decay_per_s * tau);
      const double turn = kTwoPi * sinusoid.frequency_hz * tau;
      A(i, column++) = envelope * std::cos(turn);
      A(i, column++) = -envelope * std::sin(turn);
    }
  }
  return A;
}

}  // namespace

std::vector<MarkerMotion> marker_motion(const Rig& rig,
                                        const Trace& trace,
                                        const std::vector<DampedSinusoid>& sinusoids,
                                        const InversionResult& window) {
  std::vector<MarkerMotion> motions;
  if (sinusoids.empty()) return motions;
  for (const Marker& marker : rig.markers) {
    if (marker.fixed) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const Channel* channel = trace.find(fmt::format("{}.{}_mm", marker.id, "xyz"[axis]));
      if (channel == nullptr) continue;
      const Samples samples = samples_of(trace, *channel, window);
      const Eigen::MatrixXd A = columns_of(samples, sinusoids);
      if (A.rows() <= A.cols()) continue;
      const Eigen::VectorXd y = Eigen::Map<const Eigen::VectorXd>(
          samples.value.data(), static_cast<Eigen::Index>(samples.value.size()));
      const Eigen::VectorXd x = solve_least_squares(A, y).x.col(0);
      const double scatter =
          std::sqrt((A * x - y).squaredNorm() / static_cast<double>(A.rows() - A.cols()));
      motions.push_back({marker.id,
                         axis,
                         kMetresPerMillimetre * std::complex<double>(x[2], x[3]),
                         kMetresPerMillimetre * scatter / A.col(2).norm()});
    }
  }
  return motions;
}

}  // namespace twang
