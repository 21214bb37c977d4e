// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/choose_mode.hpp"

#include "calibrate/detail/ratio.hpp"
#include "calibrate/detail/visible_share.hpp"
#include "calibrate/simulated_observable.hpp"
#include "core/dense_algebra.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

/// Share below which a mode is not seen [-].
constexpr double kFaint = 0.02;
/// Standard deviation of ln of a frequency ratio: the mesh's, and a modulus that changes between
/// the two frequencies.
constexpr double kRatioSigma = 0.02;
/// A ratio this far off, in sigmas, is not explained.
constexpr double kExplainedWithin = 3.0;
/// What a sinusoid that is no mode may have for a frequency: evenly over this range of its ln.
constexpr double kChanceRange = 3.0;
/// Below the lowest visible mode no mode can be; something else may.
constexpr double kBelowAll = 0.8;  // of its frequency
constexpr double kBelowAllPenalty = 2.0;
/// Variance of what a marker's motion departs from the shape: it may be glued on askew.
constexpr double kPatternVariance = 0.03;
constexpr double kMostPatternPenalty = 12.0;
constexpr double kPatternSignal = 5.0;  // of the motion over its sigma: it tells something
/// A reported modulus and a printed part's: standard deviation of ln of their ratio. Weak evidence,
/// for a zero too many is soon typed.
constexpr double kModulusSigma = 0.7;
constexpr double kMostModulusPenalty = 1.5;
constexpr double kModulusFits = 2.0;    // factor up to which it fits the reported one
constexpr double kModulusMisses = 4.0;  // and from which it does not
/// A choice with less than this ahead of the next is in doubt: ln of the odds.
constexpr double kClear = 1.1;
/// Evidence this much stronger for another, its ln, is told whatever the prior says.
constexpr double kTelling = 2.0;

double amplitude_of(const DampedSinusoid& sinusoid) {
  double sum = 0.0;
  for (const SinusoidInChannel& channel : sinusoid.channels) {
    sum += channel.amplitude * channel.amplitude;
  }
  return std::sqrt(sum);
}

/// Large swings have overtones at twice and three times their frequency that are no modes.
bool is_harmonic(const DampedSinusoid& sinusoid, const DampedSinusoid& strongest) {
  constexpr double kClose = 0.01;
  constexpr double kWeak = 0.1;
  const double ratio = sinusoid.frequency_hz / strongest.frequency_hz;
  const bool whole = std::abs(ratio / 2.0 - 1.0) < kClose || std::abs(ratio / 3.0 - 1.0) < kClose;
  return whole && amplitude_of(sinusoid) < kWeak * amplitude_of(strongest);
}

class Chooser {
 public:
  explicit Chooser(const ModeQuestion& question)
      : m_question(question), m_modes(question.rung->modes) {
    m_share = detail::visible_shares(*question.rig, *question.rung, question.columns);
    for (int mode = 0; mode < m_modes.count(); ++mode) {
      if (m_share[mode] < kFaint && question.stated != mode) continue;
      ModeCandidate& candidate = m_candidates.emplace_back();
      candidate.mode = mode;
      candidate.share = m_share[mode];
      candidate.modulus_pa = strongest().lambda_per_s2() / m_modes.lambda_per_s2[mode];
      candidate.prior = 2.0 * std::log(std::max(family_share(mode), 1e-9));
      weigh_ratios(candidate);
      weigh_motion(candidate);
      weigh_modulus(candidate);
    }
  }

  [[nodiscard]] ModeChoice choose() {
    ModeChoice choice;
    const ModeCandidate* best = best_of([](const ModeCandidate&) { return true; });
    if (m_question.stated) {
      choice.stated = true;
      choice.mode = *m_question.stated;
    } else {
      choice.mode = best->mode;
    }
    const ModeCandidate& chosen = *std::find_if(
        m_candidates.begin(), m_candidates.end(), [&](const ModeCandidate& candidate) {
          return candidate.mode == choice.mode;
        });
    choice.reason = reason_for(chosen);
    choice.doubt = doubt_about(chosen, *best);
    choice.candidates = m_candidates;
    return choice;
  }

 private:
  [[nodiscard]] const DampedSinusoid& strongest() const { return m_question.sinusoids.front(); }
  [[nodiscard]] bool one_family(int a, int b) const {
    const std::vector<int> family = mode_cluster(m_modes, a);
    return std::find(family.begin(), family.end(), b) != family.end();
  }
  [[nodiscard]] double family_share(int mode) const {
    double sum = 0.0;
    for (const int member : mode_cluster(m_modes, mode)) sum += m_share[member] * m_share[member];
    return std::min(1.0, std::sqrt(sum));
  }

  /// Each further sinusoid is a mode of the mesh or by chance where it is, as likely either way.
  void weigh_ratios(ModeCandidate& candidate) const {
    double all = 0.0;
    double lowest_hz = kInfinity;
    for (int mode = 0; mode < m_modes.count(); ++mode) {
      if (m_share[mode] < kFaint) continue;
      lowest_hz = std::min(lowest_hz, m_modes.natural_frequency_hz(mode));
      if (!one_family(candidate.mode, mode)) all += m_share[mode];
    }
    const double unit_hz = m_modes.natural_frequency_hz(candidate.mode);
    for (std::size_t k = 1; k < m_question.sinusoids.size(); ++k) {
      const DampedSinusoid& sinusoid = m_question.sinusoids[k];
      if (is_harmonic(sinusoid, strongest())) continue;
      const double seen_hz =
          unit_hz * sinusoid.natural_frequency_hz() / strongest().natural_frequency_hz();
      double density = 0.0;
      double nearest = kInfinity;
      for (int mode = 0; mode < m_modes.count(); ++mode) {
        if (m_share[mode] < kFaint || one_family(candidate.mode, mode)) continue;
        const double off = std::log(seen_hz / m_modes.natural_frequency_hz(mode)) / kRatioSigma;
        nearest = std::min(nearest, std::abs(off));
        density += m_share[mode] / all * std::exp(-0.5 * off * off);
      }
      density /= std::sqrt(kTwoPi) * kRatioSigma;
      candidate.evidence += std::log(0.5 * density * kChanceRange + 0.5);
      if (nearest < kExplainedWithin) {
        ++candidate.explained;
      } else if (seen_hz < kBelowAll * lowest_hz) {
        candidate.evidence -= kBelowAllPenalty;
      }
    }
  }

  /// Correlation of the measured pattern c with the span of the family's shapes there,
  /// ‖Q^T c‖ / ‖c‖.
  void weigh_motion(ModeCandidate& candidate) const {
    const auto count = static_cast<Eigen::Index>(m_question.motion.size());
    if (count < 2) return;
    Eigen::MatrixXd c(count, 2);
    double variance = 0.0;
    for (Eigen::Index i = 0; i < count; ++i) {
      const MarkerMotion& motion = m_question.motion[static_cast<std::size_t>(i)];
      c.row(i) << motion.amplitude.real(), motion.amplitude.imag();
      variance += 2.0 * motion.sigma_m * motion.sigma_m;
    }
    if (c.squaredNorm() < kPatternSignal * kPatternSignal * variance) return;
    const std::vector<int> family = mode_cluster(m_modes, candidate.mode);
    Eigen::MatrixXd shapes(count, static_cast<Eigen::Index>(family.size()));
    for (Eigen::Index i = 0; i < count; ++i) {
      const MarkerMotion& motion = m_question.motion[static_cast<std::size_t>(i)];
      const MeshPoint point =
          locate(m_question.rung->mesh, m_question.rig->find_marker(motion.marker)->position);
      for (std::size_t k = 0; k < family.size(); ++k) {
        shapes(i, static_cast<Eigen::Index>(k)) =
            interpolate(point, m_modes.shapes.col(family[k]))[motion.axis];
      }
    }
    if (!(shapes.norm() > 0.0)) return;
    const Eigen::MatrixXd fit = shapes * solve_least_squares(shapes, c).x;
    candidate.motion = fit.norm() / c.norm();
    candidate.evidence -= std::min(
        kMostPatternPenalty, (1.0 - std::pow(candidate.motion, 2)) / (2.0 * kPatternVariance));
  }

  void weigh_modulus(ModeCandidate& candidate) const {
    if (!m_question.reported_modulus_pa) return;
    const double off =
        std::log(candidate.modulus_pa / *m_question.reported_modulus_pa) / kModulusSigma;
    candidate.evidence -= std::min(kMostModulusPenalty, 0.5 * off * off);
  }

  /// The best of those asked for; of a family the member that is seen most.
  template <class Asked>
  const ModeCandidate* best_of(Asked asked) const {
    const ModeCandidate* best = nullptr;
    for (const ModeCandidate& candidate : m_candidates) {
      if (!asked(candidate)) continue;
      if (best == nullptr) {
        best = &candidate;
        continue;
      }
      constexpr double kSeenMore = 1.1;
      const bool better = one_family(best->mode, candidate.mode)
                              ? candidate.share > kSeenMore * best->share
                              : candidate.score() > best->score();
      if (better) best = &candidate;
    }
    return best;
  }

  [[nodiscard]] std::string reason_for(const ModeCandidate& chosen) const {
    std::string text = fmt::format("The sinusoid at {} Hz is taken for eigenmode {} of the mesh: ",
                                   rounded_text(strongest().frequency_hz, 4),
                                   chosen.mode + 1);
    if (m_question.stated == chosen.mode) return text + "so it was stated.";
    const bool lowest =
        &chosen == &m_candidates.front() || one_family(chosen.mode, m_candidates.front().mode);
    if (chosen.mode == 0) {
      text += "the lowest one";
    } else if (lowest) {
      text += fmt::format("the lowest that shows in what was inverted (mode 1 moves it {} as much)",
                          m_share[0] < 1e-4 ? "under 0.01 %" : percent(m_share[0] / chosen.share));
    } else {
      text += "what was seen fits it best";
    }
    if (chosen.explained > 0) {
      text += fmt::format(", and {} further sinusoid{} at the ratio{} of the mesh's frequencies",
                          chosen.explained,
                          chosen.explained == 1 ? " is" : "s are",
                          chosen.explained == 1 ? "" : "s");
    }
    const ModeCandidate* other = best_of([&](const ModeCandidate& candidate) {
      return !one_family(chosen.mode, candidate.mode) && candidate.motion < chosen.motion - 0.02;
    });
    if (other != nullptr) {
      text +=
          fmt::format(", and the markers move as in it (correlation {:.3f}; {:.3f} with mode {})",
                      chosen.motion,
                      other->motion,
                      other->mode + 1);
    }
    return text + ".";
  }

  [[nodiscard]] std::string doubt_about(const ModeCandidate& chosen,
                                        const ModeCandidate& best) const {
    if (m_question.stated) {
      if (one_family(chosen.mode, best.mode)) return {};
      return fmt::format(
          "Unless stated, eigenmode {} would have been taken: E would be {} times as "
          "large.",
          best.mode + 1,
          rounded_text(best.modulus_pa / chosen.modulus_pa, 3));
    }
    const auto others = [&](const ModeCandidate& candidate) {
      return !one_family(chosen.mode, candidate.mode);
    };
    const ModeCandidate* next = best_of(others);
    if (next == nullptr) return {};
    if (chosen.score() - next->score() < kClear) {
      return alternative(chosen, *next, "what was seen does not tell the two apart");
    }
    for (const ModeCandidate& candidate : m_candidates) {
      if (others(candidate) && candidate.evidence > chosen.evidence + kTelling) {
        return alternative(chosen,
                           candidate,
                           "what was seen fits that better, though a pluck "
                           "seldom rings it most");
      }
    }
    if (!m_question.reported_modulus_pa) return {};
    const double reported = *m_question.reported_modulus_pa;
    if (ratio_of(chosen.modulus_pa, reported) < kModulusMisses) return {};
    for (const ModeCandidate& candidate : m_candidates) {
      if (others(candidate) && ratio_of(candidate.modulus_pa, reported) < kModulusFits) {
        return alternative(chosen, candidate, "then E is near the reported one");
      }
    }
    return {};
  }

  [[nodiscard]] std::string alternative(const ModeCandidate& chosen,
                                        const ModeCandidate& other,
                                        const char* because) const {
    return fmt::format(
        "The sinusoid at {} Hz may be eigenmode {} instead of {} ({}); E would be {} "
        "times as large; --mode {} takes it for that.",
        rounded_text(strongest().frequency_hz, 4),
        other.mode + 1,
        chosen.mode + 1,
        because,
        rounded_text(other.modulus_pa / chosen.modulus_pa, 3),
        other.mode + 1);
  }

  [[nodiscard]] static std::string percent(double share) {
    return rounded_text(100.0 * share, 2) + " %";
  }

  const ModeQuestion& m_question;
  const Eigenmodes& m_modes;
  Eigen::VectorXd m_share;
  std::vector<ModeCandidate> m_candidates;
};

}  // namespace

ModeChoice choose_mode(const ModeQuestion& question) {
  const int count = question.rung->modes.count();
  if (question.stated && (*question.stated < 0 || *question.stated >= count)) {
    throw InputError(
        fmt::format("mode {} is stated, the mesh has modes 1 to {}, must be one of them",
                    *question.stated + 1,
                    count));
  }
  return Chooser(question).choose();
}

}  // namespace twang
