// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/clock_check.hpp"

#include "capture/time_base.hpp"
#include "capture/video_reader.hpp"
#include "core/constants.hpp"
#include "core/error.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace twang {
namespace {

constexpr int kHarmonics = 9;
constexpr int kColumns = 2 + 2 * kHarmonics;  // offset, drift, cosine and sine of each harmonic
constexpr std::size_t kMinFrames = 16;
constexpr std::size_t kSearchFrames = 1024;  // the search over all frequencies is quadratic in it
constexpr double kMinContrast = 1.0;         // [grey levels]
constexpr double kMinSignal = 4.0;           // amplitude of the blinking over the rest's rms
constexpr double kOutlier = 4.0;             // residuals beyond count less [robust sigmas]
constexpr double kMadPerSigma = 0.6745;  // median distance from the mean of a normal distribution
constexpr double kNoiseFloor = 1e-3;     // of the mean of a region, however clean [grey levels]
constexpr double kDoubtSigmas = 3.0;
constexpr double kDoubtRel = 1e-3;  // a phone's clock is right to some 1e-5

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Samples that are there, time from the first.
struct Samples {
  std::vector<double> time_s;
  std::vector<double> value;
  [[nodiscard]] double duration() const { return time_s.back() - time_s.front(); }
};

Samples present(const std::vector<double>& time_s, const std::vector<double>& brightness) {
  Samples samples;
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    if (!std::isfinite(brightness[i])) continue;
    samples.time_s.push_back(time_s[i]);
    samples.value.push_back(brightness[i]);
  }
  return samples;
}

/// The periodic signal of one rate that fits best.
struct PeriodicFit {
  double cost = 0.0;       // weighted squares over the noise's, and of the amplitudes over expected
  double amplitude = 0.0;  // of the fundamental
  std::vector<double> residual;
};

/// Fits a periodic signal to the first samples.
class PeriodicModel {
 public:
  PeriodicModel(const Samples& samples, std::size_t count)
      : m_samples(samples), m_count(count), m_weight(count, 1.0) {
    double lowest = samples.value[0];
    double highest = samples.value[0];
    for (std::size_t i = 0; i < count; ++i) {
      lowest = std::min(lowest, samples.value[i]);
      highest = std::max(highest, samples.value[i]);
    }
    m_expected = std::max(0.5 * (highest - lowest), kMinContrast);
    m_noise = 0.1 * m_expected;
  }

  [[nodiscard]] PeriodicFit fit(double hz) const {
    using Normal = Eigen::Matrix<double, kColumns, kColumns>;
    using Row = Eigen::Matrix<double, kColumns, 1>;
    Normal normal = Normal::Zero();
    Row right = Row::Zero();
    for (std::size_t i = 0; i < m_count; ++i) {
      const Row row = basis(hz, m_samples.time_s[i]);
      const double weight = m_weight[i] / (m_noise * m_noise);
      normal.selfadjointView<Eigen::Lower>().rankUpdate(row, weight);
      right += weight * m_samples.value[i] * row;
    }
    Row prior = Row::Zero();
    for (int k = 1; k <= kHarmonics; ++k) {
      prior[2 * k] = prior[2 * k + 1] = std::pow(k / m_expected, 2);
    }
    normal.diagonal() += prior;
    const Row coefficients = normal.selfadjointView<Eigen::Lower>().ldlt().solve(right);
    PeriodicFit result;
    result.amplitude = std::hypot(coefficients[2], coefficients[3]);
    result.cost = coefficients.cwiseAbs2().dot(prior);
    result.residual.resize(m_count);
    for (std::size_t i = 0; i < m_count; ++i) {
      result.residual[i] = m_samples.value[i] - basis(hz, m_samples.time_s[i]).dot(coefficients);
      result.cost += m_weight[i] * std::pow(result.residual[i] / m_noise, 2);
    }
    return result;
  }

  /// Takes the noise, and what does not belong to the light, from a fit.
  void learn(const PeriodicFit& fit) {
    std::vector<double> size(m_count);
    for (std::size_t i = 0; i < m_count; ++i) size[i] = std::abs(fit.residual[i]);
    const double robust = median(size) / kMadPerSigma;
    double sum = 0.0;
    double weights = 0.0;
    for (std::size_t i = 0; i < m_count; ++i) {
      const double over = size[i] / std::max(kOutlier * robust, kNoiseFloor);
      m_weight[i] = over <= 1.0 ? 1.0 : 1.0 / (over * over);
      sum += m_weight[i] * size[i] * size[i];
      weights += m_weight[i];
    }
    m_noise = std::max(std::sqrt(sum / weights), kNoiseFloor);
  }

  [[nodiscard]] double noise() const { return m_noise; }

 private:
  [[nodiscard]] Eigen::Matrix<double, kColumns, 1> basis(double hz, double time_s) const {
    Eigen::Matrix<double, kColumns, 1> row;
    row[0] = 1.0;
    row[1] = time_s / m_samples.duration();
    const double c = std::cos(kTwoPi * hz * time_s);
    const double s = std::sin(kTwoPi * hz * time_s);
    row[2] = c;
    row[3] = s;
    for (int k = 2; k <= kHarmonics; ++k) {
      row[2 * k] = row[2 * k - 2] * c - row[2 * k - 1] * s;
      row[2 * k + 1] = row[2 * k - 1] * c + row[2 * k - 2] * s;
    }
    return row;
  }

  const Samples& m_samples;
  std::size_t m_count;
  std::vector<double> m_weight;
  double m_expected = 0.0;
  double m_noise = 0.0;
};

/// The strongest frequency of the first samples, below half the frame rate.
double strongest_frequency(const Samples& samples, std::size_t count, double nyquist_hz) {
  const double duration = samples.time_s[count - 1] - samples.time_s[0];
  const std::vector<double> first(samples.value.begin(),
                                  samples.value.begin() + static_cast<std::ptrdiff_t>(count));
  const double middle = median(first);
  std::vector<double> size(count);
  for (std::size_t i = 0; i < count; ++i) size[i] = std::abs(first[i] - middle);
  std::sort(size.begin(), size.end());
  const double clip = 1.5 * size[count * 8 / 10];  // what passes in front weighs no more than light
  double mean = 0.0;
  std::vector<double> value(count);
  for (std::size_t i = 0; i < count; ++i) {
    value[i] = std::clamp(first[i] - middle, -clip, clip);
    mean += value[i] / static_cast<double>(count);
  }
  constexpr double kPerLine = 4.0;  // points on the width of a line, 1 / duration
  double best_hz = 0.0;
  double best_power = -1.0;
  for (double hz = 1.5 / duration; hz < nyquist_hz; hz += 1.0 / (kPerLine * duration)) {
    double c = 0.0;
    double s = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const double phase = kTwoPi * hz * samples.time_s[i];
      c += (value[i] - mean) * std::cos(phase);
      s += (value[i] - mean) * std::sin(phase);
    }
    if (c * c + s * s > best_power) {
      best_power = c * c + s * s;
      best_hz = hz;
    }
  }
  return best_hz;
}

struct Frequency {
  double hz = 0.0;
  double sigma_hz = 0.0;
  double amplitude = 0.0;
  double noise = 0.0;
};

/// Refines a frequency on the first samples, `reach_hz` to either side.
Frequency refine(const Samples& samples, std::size_t count, double hz, double reach_hz) {
  constexpr int kSteps =
      24;  // to either side; the ninth harmonic's line is as wide as five of them
  constexpr int kRounds = 4;
  PeriodicModel model(samples, count);
  Frequency result;
  for (int round = 0; round < kRounds; ++round) {
    const double step = reach_hz / kSteps;
    std::optional<PeriodicFit> best;
    double best_hz = hz;
    for (int i = -kSteps; i <= kSteps; ++i) {
      PeriodicFit fit = model.fit(hz + i * step);
      if (best && fit.cost >= best->cost) continue;
      best_hz = hz + i * step;
      best = std::move(fit);
    }
    const double left = model.fit(best_hz - step).cost;
    const double right = model.fit(best_hz + step).cost;
    const double bend = left - 2.0 * best->cost + right;
    double shift = bend > 0.0 ? 0.5 * (left - right) / bend : 0.0;
    hz = best_hz + std::clamp(shift, -1.0, 1.0) * step;
    // cost = cost0 + (f - f0)^2 / sigma^2
    result.sigma_hz = bend > 0.0 ? step * std::sqrt(2.0 / bend) : kNaN;
    result.amplitude = best->amplitude;
    model.learn(*best);
    reach_hz = std::max(0.25 * reach_hz, kSteps * 0.5 * result.sigma_hz);
  }
  result.hz = hz;
  result.noise = model.noise();
  return result;
}

struct Candidate {
  double hz = 0.0;
  double cost = std::numeric_limits<double>::infinity();
};

/// The best rate within a quarter of a line's width.
Candidate best_near(const PeriodicModel& model, double hz, double line_hz) {
  constexpr int kSteps = 6;
  Candidate best;
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double tried = hz + i * 0.25 * line_hz / kSteps;
    const double cost = model.fit(tried).cost;
    if (cost < best.cost) best = {tried, cost};
  }
  return best;
}

/// The fundamental of what may be a harmonic: of short flashes, all harmonics are equally strong.
/// Where sampling makes several rates look alike, it is the stated one.
double fundamental_of(const Samples& samples, std::size_t count, double peak_hz, double rate_hz) {
  constexpr int kMaxOrder = 6;
  constexpr double kMuchBetter = 0.7;  // noise alone lets a lower rate fit somewhat better
  const double line_hz = 1.0 / (samples.time_s[count - 1] - samples.time_s[0]);
  const PeriodicModel model(samples, count);
  Candidate best;
  for (int order = 1; order <= kMaxOrder && peak_hz / order > 1.5 * line_hz; ++order) {
    const Candidate candidate = best_near(model, peak_hz / order, line_hz / order);
    if (order == 1 || candidate.cost < kMuchBetter * best.cost) best = candidate;
  }
  const Candidate stated = best_near(model, rate_hz, line_hz);
  return stated.cost * kMuchBetter <= best.cost ? stated.hz : best.hz;
}

std::string likely_cause(const ClockCheck& check, double fps) {
  // Frames a true second, over frames a second of the film's time.
  const double ratio = check.stated_hz / check.measured_hz;
  const double tolerance = std::max(kDoubtSigmas * check.sigma_hz / check.measured_hz, 3e-4);
  const auto near = [&](double value) { return std::abs(ratio / value - 1.0) <= tolerance; };
  for (const double factor : {2.0, 4.0, 8.0, 16.0, 32.0}) {
    if (near(factor) || near(factor / 1.001) || near(factor * 1.001)) {
      return fmt::format(
          "slow motion, {:g} times slower than filmed: --capture-fps {:.6g}", factor, fps * ratio);
    }
    if (near(1.0 / factor)) {
      return fmt::format(
          "a capture rate stated {:g} times too high, or a light that blinks {:g} "
          "times slower",
          factor,
          factor);
    }
  }
  if (near(1.001) || near(1.0 / 1.001)) {
    return fmt::format("a television rate (240 against 239.76): --capture-fps {:.6g}", fps * ratio);
  }
  return fmt::format("a wrong frame rate: --capture-fps {:.6g} would agree", fps * ratio);
}

}  // namespace

void BlinkingLight::check() const {
  const auto refuse = [](const char* field, double value, const char* expected) {
    throw InputError(fmt::format("clock: {} is {}, must be {}", field, value, expected));
  };
  if (!(std::isfinite(x_px) && x_px >= 0.0)) refuse("x", x_px, ">= 0 px");
  if (!(std::isfinite(y_px) && y_px >= 0.0)) refuse("y", y_px, ">= 0 px");
  if (!(std::isfinite(width_px) && width_px >= 1.0)) refuse("width", width_px, ">= 1 px");
  if (!(std::isfinite(height_px) && height_px >= 1.0)) refuse("height", height_px, ">= 1 px");
  if (!(std::isfinite(rate_hz) && rate_hz > 0.0)) refuse("rate", rate_hz, "> 0 Hz");
}

double mean_brightness(const LumaFrame& frame, const BlinkingLight& light) {
  if (light.x_px + light.width_px > frame.width_px ||
      light.y_px + light.height_px > frame.height_px) {
    throw InputError(fmt::format(
        "clock: the region ends at ({:g}, {:g}) px, must be within the picture of {} x {} px",
        light.x_px + light.width_px,
        light.y_px + light.height_px,
        frame.width_px,
        frame.height_px));
  }
  const int left = static_cast<int>(light.x_px);
  const int top = static_cast<int>(light.y_px);
  const int width = static_cast<int>(light.width_px);
  const int height = static_cast<int>(light.height_px);
  long sum = 0;
  for (int y = top; y < top + height; ++y) {
    const std::uint8_t* row = frame.pixels + y * frame.stride;
    for (int x = left; x < left + width; ++x) sum += row[x];
  }
  return static_cast<double>(sum) / (static_cast<double>(width) * height);
}

ClockCheck check_clock(const std::vector<double>& time_s,
                       const std::vector<double>& brightness,
                       double rate_hz) {
  ClockCheck check;
  check.stated_hz = rate_hz;
  const Samples samples = present(time_s, brightness);
  const std::size_t count = samples.time_s.size();
  if (count < kMinFrames) {
    check.message = fmt::format("The clock was not checked: {} usable frames.", count);
    return check;
  }
  const double fps = static_cast<double>(time_s.size() - 1) / (time_s.back() - time_s.front());
  if (rate_hz > 0.5 * fps) {
    throw InputError(fmt::format(
        "clock: the rate is {:g} Hz, must be at most half the {:.6g} frames/s of the film "
        "(--capture-fps, if it was filmed faster)",
        rate_hz,
        fps));
  }
  std::size_t window = std::min(count, kSearchFrames);
  const double peak = strongest_frequency(samples, window, 0.5 * fps);
  const double coarse = fundamental_of(samples, window, peak, rate_hz);
  const auto duration = [&] { return samples.time_s[window - 1] - samples.time_s[0]; };
  Frequency found = refine(samples, window, coarse, 0.5 / duration());
  while (window < count) {
    window = std::min(count, 3 * window);
    found = refine(samples, window, found.hz, 0.5 / duration());
  }
  check.contrast = 2.0 * found.amplitude;
  if (check.contrast < kMinContrast || !(found.amplitude > kMinSignal * found.noise) ||
      !std::isfinite(found.sigma_hz)) {
    check.message = fmt::format(
        "The clock was not checked: no blinking in its region (strongest {:.2g} grey levels).",
        check.contrast);
    return check;
  }
  check.found = true;
  check.measured_hz = found.hz;
  check.sigma_hz = found.sigma_hz;
  check.deviation_rel = found.hz / rate_hz - 1.0;
  check.message = fmt::format(
      "Clock: the light of {:g} Hz blinks at {:.6g} +- {:.2g} Hz in the film's time, {:+.2g} off "
      "(+- {:.1g}).",
      rate_hz,
      found.hz,
      found.sigma_hz,
      check.deviation_rel,
      found.sigma_hz / rate_hz);
  const double doubt = std::max(kDoubtSigmas * found.sigma_hz / rate_hz, kDoubtRel);
  if (std::abs(check.deviation_rel) > doubt) {
    check.warning = fmt::format("The film's clock is wrong by a factor of {:.5g}; likely {}.",
                                rate_hz / found.hz,
                                likely_cause(check, fps));
  }
  return check;
}

void correct_by_light(TimeBase& time, ClockCheck& check) {
  if (!check.found) return;
  const double factor = check.measured_hz / check.stated_hz;
  for (double& stamp : time.time_s) stamp *= factor;
  time.summary.capture_fps /= factor;
  time.summary.source = "clock";
  check.corrected = true;
  check.message += " The time was corrected by it.";
  check.warning.clear();
}

}  // namespace twang
