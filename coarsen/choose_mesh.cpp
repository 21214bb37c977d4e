// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/ladder_steps.hpp"
#include "coarsen/detail/mesh_rung.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang {
namespace {

/// Unknowns of the reference mesh that shapes are compared with, if a rung that small is accurate:
/// the surface of a larger one costs more than it shows.
constexpr long kComparisonDofs = 120000;
/// A mesh that is to be coarse may have this share of max_dofs [-].
constexpr double kShareOfCandidate = 0.25;

/// The finest accurate rung that is not large, else the coarsest accurate one.
const MeshRung& rung_to_compare_with(const MeshLadder& ladder) {
  const auto first = static_cast<std::size_t>(ladder.accurate_rung.value_or(0));
  std::size_t chosen = first;
  for (std::size_t i = first; i < ladder.reference.size(); ++i) {
    if (ladder.reference[i].mesh.num_dofs() <= kComparisonDofs) chosen = i;
  }
  return ladder.reference[chosen];
}

/// Mean relative error of `frequencies` scaled by `factor` against `truth`, by number.
double mean_error(const Eigen::VectorXd& frequencies,
                  double factor,
                  const Eigenmodes& truth,
                  int count) {
  const int n = std::min({count, static_cast<int>(frequencies.size()), truth.count()});
  double sum = 0.0;
  for (int i = 0; i < n; ++i) {
    sum += std::abs(factor * frequencies(i) / truth.natural_frequency_hz(i) - 1.0);
  }
  return sum / n;
}

struct Tried {
  CoarseCandidate candidate;
  MeshRung rung;
};

class CandidateWalk {
 public:
  CandidateWalk(const Rig& rig, const LadderOptions& options, const MeshLadder& ladder)
      : m_rig(rig),
        m_options(options),
        m_comparison(rung_to_compare_with(ladder)),
        m_finest(ladder.reference.back()) {}

  [[nodiscard]] const MeshRung& comparison() const { return m_comparison; }

  [[nodiscard]] bool affordable(double dx_m) const {
    return static_cast<double>(count_dofs(m_rig, dx_m, ElementKind::Hex8)) <=
           kShareOfCandidate * static_cast<double>(m_options.max_dofs);
  }

  /// @throws InputError if the part cannot be meshed at this dx
  [[nodiscard]] Tried run(double dx_m) const {
    Tried tried;
    tried.rung = compute_rung(m_rig,
                              dx_m,
                              ElementKind::Hex8,
                              std::max(m_options.num_frequencies, m_options.num_modes + 4),
                              m_options.progress);
    const Eigenmodes& modes = tried.rung.modes;
    CoarseCandidate& candidate = tried.candidate;
    candidate.dx_m = dx_m;
    candidate.num_elements = tried.rung.mesh.num_elements();
    candidate.natural_frequency_hz.resize(modes.count());
    for (int i = 0; i < modes.count(); ++i) {
      candidate.natural_frequency_hz(i) = modes.natural_frequency_hz(i);
    }
    candidate.comparison = compare_modes(m_comparison, tried.rung, m_options.num_modes);
    candidate.passes = modes.count() >= m_options.num_modes &&
                       candidate.comparison.max_difference <= m_options.shape_tolerance;
    const int count = m_options.num_frequencies;
    const double factor = m_finest.modes.natural_frequency_hz(0) / modes.natural_frequency_hz(0);
    candidate.mean_frequency_error_before =
        mean_error(candidate.natural_frequency_hz, 1.0, m_finest.modes, count);
    candidate.mean_frequency_error_after =
        mean_error(candidate.natural_frequency_hz, factor, m_finest.modes, count);
    return tried;
  }

 private:
  const Rig& m_rig;
  const LadderOptions& m_options;
  const MeshRung& m_comparison;
  const MeshRung& m_finest;
};

std::string sentence(const CoarseCandidate& candidate,
                     const MeshRung& coarse,
                     const MeshRung& fine,
                     const LadderOptions& options,
                     bool wanted) {
  const std::string agreement = fmt::format(
      "{} first {} mode shapes differ from those of {} by up to {:.2g} % of the peak ({:.2g} % is "
      "allowed)",
      wanted ? "its" : "the",
      options.num_modes,
      describe(fine.mesh),
      100.0 * candidate.comparison.max_difference,
      100.0 * options.shape_tolerance);
  return fmt::format("{} ({} elements), {}: {}",
                     describe(coarse.mesh),
                     candidate.num_elements,
                     wanted             ? "as asked for"
                     : candidate.passes ? "the coarsest that keeps the shapes"
                                        : "the finest tried, none keeps the shapes",
                     agreement);
}

}  // namespace

void choose_mesh(const Rig& rig,
                 double start_dx_m,
                 const LadderOptions& options,
                 MeshLadder& ladder) {
  const CandidateWalk walk(rig, options, ladder);
  std::vector<Tried> tried;  // fine to coarse
  if (options.coarse_dx_m) {
    tried.push_back(walk.run(*options.coarse_dx_m));
  } else {
    double dx = walk.affordable(start_dx_m / 2.0) ? start_dx_m / 2.0 : start_dx_m;
    tried.push_back(walk.run(dx));
    while (!tried.front().candidate.passes && walk.affordable(tried.front().candidate.dx_m / 2.0)) {
      tried.insert(tried.begin(), walk.run(tried.front().candidate.dx_m / 2.0));
    }
    // Coarser ones, as long as the shapes agree and the solids do not slip through the cells.
    while (tried.back().candidate.passes) {
      try {
        tried.push_back(walk.run(2.0 * tried.back().candidate.dx_m));
      } catch (const InputError&) {
        break;
      }
    }
  }
  std::size_t chosen = 0;
  for (std::size_t i = 0; i < tried.size(); ++i) {
    if (tried[i].candidate.passes) chosen = i;
    ladder.candidates.push_back(tried[i].candidate);
  }
  const CoarseCandidate& candidate = tried[chosen].candidate;
  ladder.coarse = std::move(tried[chosen].rung);
  ladder.choice = sentence(
      candidate, ladder.coarse, walk.comparison(), options, options.coarse_dx_m.has_value());
  if (!candidate.passes) {
    ladder.notes.push_back(fmt::format("the mode shapes of {} differ by {:.2g} %, above {:.2g} %",
                                       describe(ladder.coarse.mesh),
                                       100.0 * candidate.comparison.max_difference,
                                       100.0 * options.shape_tolerance));
  }
}

}  // namespace twang
