// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/find_repeats.hpp"

#include "core/constants.hpp"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace twang::detail {
namespace {

constexpr int kEnough = 22;     // samples for a fit: three times its terms
constexpr int kAtLeast = 13;    // twice its terms
constexpr int kReach = 44;      // frames on either side in which they are looked for
constexpr int kNumOmegas = 52;  // grid from 0 to half the frame rate: ω within a tenth of a radian
                                // over the window, the rest is left to the terms b and d
constexpr int kMaxTerms = 6;
constexpr double kFloor_px = 0.015;  // no track is better than this in a compressed film [px]
constexpr double kMotion_px = 0.3;   // range of a path below which it shows no motion [px]
constexpr double kAway = 6.0;        // standard errors between a repeat and its proper place
constexpr double kNear = 4.0;        // standard errors within which a sample is where it should be
constexpr double kStands = 0.3;      // of the step that is missing
constexpr double kMuchBetter = 0.4;  // ratio of residuals
constexpr double kFits = 0.1;        // residual over the range of motion

/// One coordinate of one marker.
struct Path {
  const MarkerTrack* track = nullptr;
  int axis = 0;
  [[nodiscard]] double at(std::size_t n) const { return track->position_px[n][axis]; }
};

/// A path's fit about a frame.
struct LocalFit {
  double omega = 0.0;  // 0: cubic
  Eigen::VectorXd coefficients;
  Eigen::MatrixXd covariance;  // over the squared residual
  double residual_px = kNaN;

  struct Expected {
    double at_px;
    double error_px;
  };
  [[nodiscard]] Expected at(double t) const;
};

Eigen::RowVectorXd terms(double omega, double t) {
  if (omega == 0.0) return Eigen::RowVector4d(1.0, t, t * t, t * t * t);
  const double c = std::cos(omega * t);
  const double s = std::sin(omega * t);
  Eigen::RowVectorXd row(kMaxTerms);
  row << 1.0, t, c, s, t * c, t * s;
  return row;
}

LocalFit::Expected LocalFit::at(double t) const {
  const Eigen::RowVectorXd row = terms(omega, t);
  return {row * coefficients,
          residual_px * std::sqrt(1.0 + (row * covariance * row.transpose()).value())};
}

struct Samples {
  std::vector<double> t;  // from the frame in question [frames]
  std::vector<double> y;  // [px]
};

std::optional<LocalFit> fit_with(double omega, const Samples& samples) {
  const auto rows = static_cast<Eigen::Index>(samples.t.size());
  Eigen::MatrixXd A(rows, terms(omega, 0.0).size());
  for (Eigen::Index i = 0; i < rows; ++i) {
    A.row(i) = terms(omega, samples.t[static_cast<std::size_t>(i)]);
  }
  const Eigen::Map<const Eigen::VectorXd> y(samples.y.data(), rows);
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
  if (qr.rank() < A.cols() || rows <= A.cols()) return std::nullopt;
  LocalFit fit;
  fit.omega = omega;
  fit.coefficients = qr.solve(y);
  const double freedom = static_cast<double>(rows - A.cols());
  fit.residual_px = std::max(kFloor_px, (A * fit.coefficients - y).norm() / std::sqrt(freedom));
  fit.covariance = (A.transpose() * A).ldlt().solve(Eigen::MatrixXd::Identity(A.cols(), A.cols()));
  return fit;
}

/// The fit of the frequency that suits best, the smooth one where none does better.
std::optional<LocalFit> best_fit(const Samples& samples) {
  if (samples.t.size() < kAtLeast) return std::nullopt;
  std::optional<LocalFit> best;
  for (int i = 0; i < kNumOmegas; ++i) {
    std::optional<LocalFit> fit = fit_with(kPi * i / kNumOmegas, samples);
    if (fit && (!best || fit->residual_px < best->residual_px)) best = std::move(fit);
  }
  return best;
}

class RepeatFinder {
 public:
  RepeatFinder(const std::vector<MarkerTrack>& tracks, const std::vector<Likeness>& likeness)
      : m_likeness(likeness), m_repeats(likeness.size(), false), m_order(likeness.size(), 0) {
    for (const MarkerTrack& track : tracks) {
      for (const int axis : {0, 1}) m_paths.push_back({&track, axis});
    }
    for (std::size_t n = 0; n < likeness.size(); ++n) {
      m_repeats[n] = likeness[n] == Likeness::Same;
      m_order[n] = (n > 0 ? m_order[n - 1] : 0) + (likeness[n] == Likeness::Different ? 1 : 0);
    }
  }

  std::vector<bool> find() {
    for (std::size_t n = 1; n < m_likeness.size(); ++n) {
      if (m_likeness[n] == Likeness::Alike) m_repeats[n] = stands_still(n);
    }
    return std::move(m_repeats);
  }

 private:
  enum class Witness { Different, NoRepeat };  // which frames a fit may use

  [[nodiscard]] bool may_use(std::size_t n, Witness witness) const {
    return witness == Witness::Different ? m_likeness[n] == Likeness::Different : !m_repeats[n];
  }

  /// Calls `use` with frames about `frame`, the nearest first, until it says that it has enough.
  template <typename Function>
  void for_each_around(std::size_t frame, Witness witness, const Function& use) const {
    for (std::size_t away = 1; away <= kReach; ++away) {
      const bool before = frame >= away && may_use(frame - away, witness);
      const bool after = frame + away < m_likeness.size() && may_use(frame + away, witness);
      if (before && !use(frame - away)) return;
      if (after && !use(frame + away)) return;
    }
  }

  /// Samples about `frame`; `in_order`: counted on, without the frames that may be repeats.
  [[nodiscard]] Samples samples(const Path& path,
                                std::size_t frame,
                                Witness witness,
                                bool in_order) const {
    Samples result;
    for_each_around(frame, witness, [&](std::size_t n) {
      if (!std::isfinite(path.at(n))) return true;
      result.t.push_back(in_order ? m_order[n] - m_order[frame]
                                  : static_cast<double>(n) - static_cast<double>(frame));
      result.y.push_back(path.at(n));
      return result.t.size() < kEnough;
    });
    return result;
  }

  struct Liveliest {
    Path path;
    double range_px = 0.0;
  };
  [[nodiscard]] Liveliest liveliest(std::size_t frame, std::size_t origin, Witness witness) const {
    Liveliest best;
    for (const Path& path : m_paths) {
      if (!std::isfinite(path.at(frame)) || !std::isfinite(path.at(origin))) continue;
      double low = path.at(origin);
      double high = low;
      int count = 0;
      for_each_around(frame, witness, [&](std::size_t n) {
        if (!std::isfinite(path.at(n))) return true;
        low = std::min(low, path.at(n));
        high = std::max(high, path.at(n));
        return ++count < kEnough;
      });
      if (high - low > best.range_px) best = {path, high - low};
    }
    return best;
  }

  [[nodiscard]] bool stands_still(std::size_t frame) const {
    std::size_t origin = frame - 1;  // the picture that would be repeated
    while (origin > 0 && m_repeats[origin]) --origin;
    return stands_still(frame, origin, Witness::Different) ||
           stands_still(frame, origin, Witness::NoRepeat);
  }

  [[nodiscard]] bool stands_still(std::size_t frame, std::size_t origin, Witness witness) const {
    const auto [path, range_px] = liveliest(frame, origin, witness);
    if (range_px < kMotion_px) return false;
    const std::optional<LocalFit> fit = best_fit(samples(path, frame, witness, false));
    if (!fit) return false;
    const double here = path.at(frame);
    const double there = path.at(origin);
    const LocalFit::Expected now = fit->at(0.0);
    const LocalFit::Expected then =
        fit->at(static_cast<double>(origin) - static_cast<double>(frame));
    const bool stood = std::abs(here - there) < kStands * std::abs(now.at_px - there);
    const bool should_have_moved = std::abs(now.at_px - here) > kAway * now.error_px;
    const bool was_right = std::abs(then.at_px - there) < kNear * then.error_px;
    if (stood && should_have_moved && was_right) return true;
    if (witness != Witness::Different) return false;
    const std::optional<LocalFit> without = best_fit(samples(path, frame, witness, true));
    return without && without->residual_px < kFits * range_px &&
           without->residual_px < kMuchBetter * fit->residual_px;
  }

  const std::vector<Likeness>& m_likeness;
  std::vector<bool> m_repeats;
  std::vector<int> m_order;  // of the frames that are different, counted on
  std::vector<Path> m_paths;
};

}  // namespace

std::vector<bool> find_repeats(const std::vector<MarkerTrack>& tracks,
                               const std::vector<Likeness>& likeness) {
  return RepeatFinder(tracks, likeness).find();
}

}  // namespace twang::detail
