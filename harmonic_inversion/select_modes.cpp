// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/select_modes.hpp"

#include "core/constants.hpp"
#include "harmonic_inversion/mode_criteria.hpp"
#include "harmonic_inversion/projected_fit.hpp"
#include "harmonic_inversion/propose_poles.hpp"
#include "harmonic_inversion/second_order_bias.hpp"
#include "harmonic_inversion/weighted_data.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace twang {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Proposals refined in full; the others are dropped on their linear fit.
constexpr std::size_t kRefinedProposals = 2;
/// Rounds of adding, dropping and weighing.
constexpr int kMaxRounds = 5;
/// Rounds of weighing by robust factors, and their change at which it ends.
constexpr int kMaxReweights = 15;
constexpr double kSettledFactor = 0.01;
/// The residual is searched again after this many proposals in a row were refused, no more.
constexpr int kMaxRefusals = 6;
/// Amplitude over sigma of a candidate that is dropped with others, and of one that is dropped
/// alone.
constexpr double kHopeless = 2.0;
constexpr double kDoubtful = 4.0;
/// Samples of a record that the matrix pencil sees too little of.
constexpr int kLongRecord = 4096;
/// A peak on the grid of the search has at least this part of the gain between its points.
constexpr double kHopefulGain = 0.6;

class Selector {
 public:
  /// @param robust  outliers in short runs count less, see `robust_factors`
  Selector(const std::vector<SampleSeries>& series, const SelectionOptions& options, bool robust)
      : m_data(series, options.step_s), m_options(options), m_criteria(series, options) {
    m_data.is_robust = robust;
  }

  ModeSelection run() {
    m_best = trial({});
    if (!is_exact()) {
      if (!m_data.is_robust) {
        start_from_proposals();
        weigh_channels();  // before the search, lest it explains outliers
      }
      for (int round = 0; round < kMaxRounds; ++round) {
        const std::size_t poles = m_best.poles.size();
        const int outliers = m_data.num_outliers();
        extend();
        prune();
        weigh_channels();
        if (m_best.poles.size() == poles && m_data.num_outliers() == outliers) break;
      }
      settle_drift();
      settle_decays();
    }
    return finish();
  }

  /// Whether outliers in short runs may be in the record: they are seen, or several modes may stand
  /// for them; or whether outliers stand for the only mode. Beside the modes of a long record they
  /// weigh little.
  [[nodiscard]] bool may_hide_outliers(const ModeSelection& chosen) const {
    return m_data.saw_runs_of_outliers() || (chosen.fit.poles.empty() && chosen.num_outliers > 0) ||
           (chosen.fit.poles.size() > 1 && chosen.fit.num_samples < kLongRecord);
  }

  /// Of what `run` has chosen, for comparison with another that weighs the samples otherwise.
  [[nodiscard]] double criterion(const ModeSelection& chosen) const {
    return m_data.criterion(chosen.fit);
  }

 private:
  [[nodiscard]] SinusoidFit trial(const std::vector<DampedPole>& poles) const {
    return refine_sinusoids(m_data.series(), poles, m_data.trial_options());
  }

  [[nodiscard]] bool is_exact() const { return m_data.is_round_off(m_best); }

  /// Filter diagonalization first; the pencil where that leaves something to be explained.
  void start_from_proposals() {
    const SinusoidFit baseline = m_best;
    for (const auto& propose : {propose_by_filter_diagonalization, propose_by_matrix_pencil}) {
      std::vector<PoleProposal> proposals;
      for (std::size_t c = 0; c < m_data.series().size(); ++c) {
        SampleSeries level = m_data.series()[c];
        level.value = m_data.residual(baseline, c);
        for (PoleProposal& proposal : propose(level, m_options.step_s, m_options.band_hz)) {
          for (PoleCandidate& candidate : proposal.candidates) settle_growth(candidate.pole);
          proposals.push_back(std::move(proposal));
        }
      }
      if (try_proposals(proposals)) return;
      // The pencil sees a few hundred samples; of a long record's rest the search knows more.
      if (!m_best.poles.empty() && m_best.num_samples > kLongRecord) return;
    }
  }

  /// Refines the few proposals that explain most as they stand and keeps the best fit; true if
  /// nothing is left to be explained.
  bool try_proposals(std::vector<PoleProposal>& proposals) {
    std::vector<std::pair<double, std::size_t>> ranked;
    for (std::size_t i = 0; i < proposals.size(); ++i) {
      report_progress(m_options.progress, {"looking for modes", 0.0, 0.0});
      ranked.emplace_back(bayes_criterion(thin_out(proposals[i])), i);
    }
    std::sort(ranked.begin(), ranked.end());
    if (ranked.size() > kRefinedProposals) ranked.resize(kRefinedProposals);
    for (const auto& [criterion, index] : ranked) {
      report_progress(m_options.progress, {"looking for modes", 0.0, 0.0});
      const std::vector<DampedPole> start = poles_of(proposals[index]);
      if (start.empty()) continue;
      SinusoidFit kept = std::exchange(m_best, trial(start));
      std::vector<RejectedMode> rejected = std::exchange(m_rejected, {});
      prune();
      if (bayes_criterion(m_best) >= bayes_criterion(kept)) {
        m_best = std::move(kept);
        m_rejected = std::move(rejected);
        continue;
      }
      m_finder = proposals[index].finder;
      m_proposed = start;
      polish();
      if (is_exact() || find_peaks({}).empty()) return true;
    }
    return false;
  }

  /// What is found in a part of the record may grow out of all bounds in the whole.
  void settle_growth(DampedPole& pole) const {
    if (-pole.decay_per_s * m_criteria.duration_s() > kMaxGrowthExponent) pole.decay_per_s = 0.0;
  }

  static std::vector<DampedPole> poles_of(const PoleProposal& proposal) {
    std::vector<DampedPole> out;
    for (const PoleCandidate& candidate : proposal.candidates) out.push_back(candidate.pole);
    return out;
  }

  /// Drops candidates whose amplitude is lost in the residual, poles held fixed: the hopeless at
  /// once, the doubtful weakest first.
  SinusoidFit thin_out(PoleProposal& proposal) const {
    std::vector<PoleCandidate>& candidates = proposal.candidates;
    const auto limit = static_cast<std::size_t>(m_options.max_candidates);
    if (candidates.size() > limit) candidates.resize(limit);
    while (true) {
      SinusoidFit fit = fit_amplitudes(m_data.series(), poles_of(proposal), m_data.trial_options());
      if (candidates.empty()) return fit;
      std::vector<double> strength;
      for (std::size_t k = 0; k < candidates.size(); ++k) {
        strength.push_back(m_criteria.amplitude_over_sigma(fit, k));
      }
      const double least = *std::min_element(strength.begin(), strength.end());
      if (least > kDoubtful) return fit;
      const double limit_now = std::max(least, kHopeless);
      std::vector<PoleCandidate> kept;
      for (std::size_t k = 0; k < candidates.size(); ++k) {
        if (strength[k] > limit_now) kept.push_back(candidates[k]);
      }
      candidates = std::move(kept);
    }
  }

  /// Takes a fit that is close to exact all the way, lest its last digits pass for modes.
  void polish() {
    if (!m_data.is_nearly_exact(m_best)) return;
    m_best = refine_sinusoids(m_data.series(), m_best.poles, m_data.final_options());
  }

  /// The place that explains most of the residual; none if it cannot be worth a mode.
  [[nodiscard]] std::vector<PoleCandidate> find_peaks(
      const std::vector<DampedPole>& refused) const {
    auto peaks = search_residual(
        m_data.weighted_residuals(m_best), m_options.step_s, m_options.band_hz, refused, 1);
    const double needed = kHopefulGain * m_criteria.least_gain(m_best.num_samples);
    std::erase_if(peaks, [&](const PoleCandidate& peak) { return peak.amplitude < needed; });
    return peaks;
  }

  /// Adds the best-explaining sinusoid again and again.
  void extend() {
    std::vector<DampedPole> refused;
    for (int refusals = 0; refusals < kMaxRefusals;) {
      report_progress(m_options.progress, {"looking for modes", 0.0, 0.0});
      polish();
      if (is_exact()) return;
      const auto peaks = find_peaks(refused);
      if (peaks.empty()) return;
      const std::vector<SampleSeries> residuals = m_data.weighted_residuals(m_best);
      const SinusoidFit single =
          refine_sinusoids(residuals, {peaks.front().pole}, m_data.residual_options(residuals));
      std::vector<DampedPole> poles = m_best.poles;
      poles.push_back(single.poles.front());
      SinusoidFit fit = trial(poles);
      if (!m_criteria.is_supported(m_best, fit)) {
        // The first refusal for want of evidence ends the search: every other gain is smaller.
        if (refusals > 0 || !retry_from(peaks.front().pole, fit)) return;
      }
      const std::size_t last = fit.poles.size() - 1;
      std::optional<std::string> objection = m_criteria.objection(fit, last);
      if (!objection) objection = m_criteria.overlap_objection(fit, last, m_best);
      if (objection) {
        reject(fit.poles[last], *objection);
        refused.push_back(peaks.front().pole);
        ++refusals;
        continue;
      }
      m_best = std::move(fit);
      if (m_data.is_robust) weigh_channels();  // lest the next mode explains outliers
      if (m_finder.empty()) m_finder = "search of the residual";
    }
  }

  /// A local fit may have run away; the peak itself may do better.
  bool retry_from(const DampedPole& peak, SinusoidFit& fit) const {
    std::vector<DampedPole> poles = m_best.poles;
    poles.push_back(peak);
    fit = trial(poles);
    return m_criteria.is_supported(m_best, fit);
  }

  /// Drops what does not stand up to the criteria, weakest first: what is no vibration at all
  /// before what is compared with its neighbours.
  void prune() {
    while (drop_first(&Selector::is_no_vibration) || drop_first(&Selector::is_not_needed)) {
    }
  }

  using Verdict = std::optional<std::string> (Selector::*)(std::size_t k,
                                                           SinusoidFit& without) const;

  /// Drops the weakest pole that `verdict` is against; false if there is none.
  bool drop_first(Verdict verdict) {
    for (const std::size_t k : m_criteria.by_energy(m_best)) {
      SinusoidFit without;
      const std::optional<std::string> reason = (this->*verdict)(k, without);
      if (!reason) continue;
      reject(m_best.poles[k], *reason);
      m_best = std::move(without);
      return true;
    }
    return false;
  }

  std::optional<std::string> is_no_vibration(std::size_t k, SinusoidFit& without) const {
    const std::optional<std::string> reason = m_criteria.objection(m_best, k);
    if (reason) without = trial(poles_without(k));
    return reason;
  }

  std::optional<std::string> is_not_needed(std::size_t k, SinusoidFit& without) const {
    if (is_exact()) {
      // Of round-off the criteria know nothing.
      without = refine_sinusoids(m_data.series(), poles_without(k), m_data.final_options());
      if (m_data.is_round_off(without)) return "the data are exact without it";
      return std::nullopt;
    }
    if (!m_criteria.needs_refit_to_judge(m_best, k)) return std::nullopt;
    without = trial(poles_without(k));
    if (!m_criteria.is_supported(without, m_best)) return "not supported by the data";
    return m_criteria.overlap_objection(m_best, k, without);
  }

  [[nodiscard]] std::vector<DampedPole> poles_without(std::size_t k) const {
    std::vector<DampedPole> out = m_best.poles;
    out.erase(out.begin() + static_cast<std::ptrdiff_t>(k));
    return out;
  }

  void reject(const DampedPole& pole, const std::string& reason) {
    const double width = 1.0 / m_criteria.duration_s();
    const bool known = std::any_of(m_rejected.begin(), m_rejected.end(), [&](const auto& other) {
      return other.reason == reason && std::abs(other.frequency_hz - pole.frequency_hz) < width;
    });
    if (!known) m_rejected.push_back({pole.frequency_hz, pole.decay_per_s, reason});
  }

  void weigh_channels() {
    for (int i = 0; i < kMaxReweights; ++i) {
      const double change = m_data.weigh(m_best);
      m_best = trial(m_best.poles);
      if (!m_data.is_robust || change < kSettledFactor) return;
    }
  }

  /// The drift is kept only if the criterion wants it.
  void settle_drift() {
    RefineOptions options = m_data.final_options();
    m_best = refine_sinusoids(m_data.series(), m_best.poles, options);
    options.fit_drift = false;
    SinusoidFit level = refine_sinusoids(m_data.series(), m_best.poles, options);
    if (bayes_criterion(level) > bayes_criterion(m_best) && !m_data.is_round_off(level)) return;
    m_data.fit_drift = false;
    m_best = std::move(level);
    prune();
    m_best = refine_sinusoids(m_data.series(), m_best.poles, m_data.final_options());
  }

  /// Decays below 0 by no more than chance are 0.
  void settle_decays() {
    std::vector<bool> steady(m_best.poles.size(), false);
    std::vector<DampedPole> poles = m_best.poles;
    for (std::size_t k = 0; k < poles.size(); ++k) {
      if (poles[k].decay_per_s >= 0.0 || m_criteria.is_growing(m_best, k)) continue;
      poles[k].decay_per_s = 0.0;
      steady[k] = true;
    }
    if (std::find(steady.begin(), steady.end(), true) == steady.end()) return;
    RefineOptions options = m_data.final_options();
    options.fixed_decays = steady;
    SinusoidFit fit = refine_sinusoids(m_data.series(), poles, options);
    for (std::size_t k = 0; k < poles.size(); ++k) {
      // A decay at its bound still has the uncertainty of the free fit.
      const Index i = 2 * static_cast<Index>(k) + 1;
      if (steady[k]) fit.pole_covariance(i, i) = m_best.pole_covariance(i, i);
    }
    m_best = std::move(fit);
  }

  /// Of modes that are gone within some samples, or near one another, the bias shows. A decay at
  /// its bound has another one.
  void correct_bias() {
    if (m_best.poles.empty() || is_exact()) return;
    const bool is_bound = std::any_of(m_best.poles.begin(), m_best.poles.end(), [](const auto& p) {
      return p.decay_per_s == 0.0;
    });
    if (is_bound) return;
    auto corrected =
        without_bias(m_data.series(), m_best, m_data.weights(), m_data.final_options());
    if (!corrected) return;
    m_best = std::move(*corrected);
    for (std::size_t c = 0; c < m_data.series().size(); ++c)
      m_best.channels[c].residual = m_data.residual(m_best, c);
  }

  ModeSelection finish() {
    ModeSelection out;
    for (std::size_t k = 0; k < m_best.poles.size(); ++k) {
      out.is_growing.push_back(m_criteria.is_growing(m_best, k));
      double nearest = kNaN;
      for (const DampedPole& p : m_proposed) {
        const DampedPole& q = m_best.poles[k];
        const double distance =
            std::hypot(kTwoPi * (p.frequency_hz - q.frequency_hz), p.decay_per_s - q.decay_per_s) /
            std::hypot(kTwoPi * q.frequency_hz, q.decay_per_s);
        if (!(nearest <= distance)) nearest = distance;
      }
      out.errors.push_back(nearest);
    }
    for (std::size_t c = 0; c < m_data.series().size(); ++c) {
      m_best.channels[c].residual = m_data.residual(m_best, c);
      out.moment_mismatch = std::max(out.moment_mismatch, m_data.moment_mismatch(m_best, c));
    }
    correct_bias();
    out.fit = std::move(m_best);
    out.rejected = std::move(m_rejected);
    out.finder = m_finder;
    out.num_outliers = m_data.num_outliers();
    out.is_outlier = m_data.outliers();
    out.scatter = m_data.scatter();
    out.num_down_weighted = m_data.num_down_weighted();
    return out;
  }

  WeightedData m_data;
  const SelectionOptions& m_options;
  ModeCriteria m_criteria;
  SinusoidFit m_best;
  std::vector<DampedPole> m_proposed;
  std::vector<RejectedMode> m_rejected;
  std::string m_finder;
};

}  // namespace

ModeSelection select_modes(const std::vector<SampleSeries>& series,
                           const SelectionOptions& options) {
  options.check();
  Selector plain(series, options, false);
  ModeSelection chosen = plain.run();
  if (!plain.may_hide_outliers(chosen)) return chosen;
  // Modes and outliers may stand for one another: what is gone within some samples is a mode if
  // that takes fewer unknowns than outliers do, and a marker's jump is no sum of modes.
  Selector robust(series, options, true);
  ModeSelection other = robust.run();
  return robust.criterion(other) < plain.criterion(chosen) ? other : chosen;
}

}  // namespace twang
