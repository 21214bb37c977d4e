// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/ladder_steps.hpp"
#include "coarsen/detail/mesh_rung.hpp"
#include "coarsen/follow_mode.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang {
namespace {

/// Unknowns of the reference mesh that shapes are compared with, if a rung that small is accurate.
constexpr double kComparisonDofs = 2e6;
/// A mesh that is to be coarse may have this share of max_dofs, or of the unknowns of the finest
/// reference mesh [-].
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
        m_finest(ladder.reference.back()),
        m_several(has_several_materials(rig)) {}

  [[nodiscard]] const MeshRung& comparison() const { return m_comparison; }

  [[nodiscard]] bool affordable(double dx_m) const {
    const long largest = std::max(m_options.max_dofs, static_cast<long>(m_finest.mesh.num_dofs()));
    return static_cast<double>(count_dofs(m_rig, dx_m, m_options.coarse_element)) <=
           kShareOfCandidate * static_cast<double>(largest);
  }

  /// @throws InputError if the part cannot be meshed at this dx
  [[nodiscard]] Tried run(double dx_m) const { return run(dx_m, m_options.coarse_element); }

  [[nodiscard]] Tried run(double dx_m, ElementKind element) const {
    const int num_modes = std::max(m_options.num_frequencies, m_options.num_modes + 4);
    Tried tried;
    tried.rung = compute_ladder_rung(m_rig, dx_m, element, num_modes, m_options.progress);
    const Eigenmodes& modes = tried.rung.modes;
    CoarseCandidate& candidate = tried.candidate;
    candidate.dx_m = dx_m;
    candidate.element = element;
    candidate.num_elements = tried.rung.mesh.num_elements();
    if (m_several) candidate.num_mixed_cells = count_mixed_cells(m_rig, dx_m).num_mixed;
    candidate.natural_frequency_hz.resize(modes.count());
    for (int i = 0; i < modes.count(); ++i) {
      candidate.natural_frequency_hz(i) = modes.natural_frequency_hz(i);
    }
    candidate.comparison = compare_modes(m_comparison, tried.rung, m_options.num_modes);
    candidate.passes = modes.count() >= m_options.num_modes && candidate.num_mixed_cells == 0 &&
                       !is_comparison(tried.rung) &&
                       candidate.comparison.max_difference <= m_options.shape_tolerance;
    const int count = m_options.num_frequencies;
    candidate.rescale = m_finest.modes.natural_frequency_hz(0) / modes.natural_frequency_hz(0);
    candidate.mean_frequency_error_before =
        mean_error(candidate.natural_frequency_hz, 1.0, m_finest.modes, count);
    candidate.mean_frequency_error_after =
        mean_error(candidate.natural_frequency_hz, candidate.rescale, m_finest.modes, count);
    for (int i = 0; i < m_finest.modes.count(); ++i) {
      candidate.mode_of_reference.push_back(follow_mode(m_finest, i, tried.rung).mode);
    }
    return tried;
  }

 private:
  /// Whether a mesh would be compared with itself.
  [[nodiscard]] bool is_comparison(const MeshRung& rung) const {
    return rung.mesh.kind == m_comparison.mesh.kind &&
           rung.mesh.num_elements() == m_comparison.mesh.num_elements();
  }

  const Rig& m_rig;
  const LadderOptions& m_options;
  const MeshRung& m_comparison;
  const MeshRung& m_finest;
  bool m_several;  // materials
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
                                        : "the finest tried, none passes",
                     agreement);
}

/// The meshes tried, fine to coarse: finer than the start until one passes, coarser as long as one
/// does and the solids do not slip through the cells.
std::vector<Tried> walk_down(const CandidateWalk& walk,
                             double start_dx_m,
                             const LadderOptions& options) {
  std::vector<Tried> tried;
  if (options.coarse_dx_m) {
    tried.push_back(walk.run(*options.coarse_dx_m));
    return tried;
  }
  const double dx_m = walk.affordable(start_dx_m / 2.0) ? start_dx_m / 2.0 : start_dx_m;
  tried.push_back(walk.run(dx_m));
  while (!tried.front().candidate.passes && walk.affordable(tried.front().candidate.dx_m / 2.0)) {
    tried.insert(tried.begin(), walk.run(tried.front().candidate.dx_m / 2.0));
  }
  while (tried.back().candidate.passes) {
    try {
      tried.push_back(walk.run(2.0 * tried.back().candidate.dx_m));
    } catch (const InputError&) {
      break;
    }
  }
  return tried;
}

/// The coarsest that passes; if none does, the finest whose cells hold one material each, else the
/// finest.
std::size_t choose_of(const std::vector<CoarseCandidate>& candidates) {
  for (std::size_t i = candidates.size(); i-- > 0;) {
    if (candidates[i].passes) return i;
  }
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (candidates[i].num_mixed_cells == 0) return i;
  }
  return 0;
}

/// What is to be said of cells that hold two materials, of the meshes tried, fine to coarse.
void note_mixed_cells(const std::vector<Tried>& tried, std::size_t chosen, MeshLadder& ladder) {
  const CoarseCandidate& taken = tried[chosen].candidate;
  if (taken.num_mixed_cells > 0) {
    ladder.notes.push_back(
        fmt::format("{} of the {} cells of {} hold more than one material, each is of the one at "
                    "its centre",
                    taken.num_mixed_cells,
                    taken.num_elements,
                    describe(tried[chosen].rung.mesh)));
    return;
  }
  if (chosen + 1 >= tried.size() || tried[chosen + 1].candidate.num_mixed_cells == 0) return;
  const CoarseCandidate& next = tried[chosen + 1].candidate;
  ladder.notes.push_back(fmt::format(
      "coarsening ends at {}: of the {} cells of {} {} would hold more than one material",
      millimetres(taken.dx_m),
      next.num_elements,
      millimetres(next.dx_m),
      next.num_mixed_cells));
}

}  // namespace

void choose_mesh(const Rig& rig,
                 double start_dx_m,
                 const LadderOptions& options,
                 MeshLadder& ladder) {
  const CandidateWalk walk(rig, options, ladder);
  std::vector<Tried> tried = walk_down(walk, start_dx_m, options);
  for (const Tried& one : tried) ladder.candidates.push_back(one.candidate);
  const std::size_t chosen = choose_of(ladder.candidates);
  const CoarseCandidate& candidate = tried[chosen].candidate;
  const MeshRung& rung = tried[chosen].rung;
  ladder.choice =
      sentence(candidate, rung, walk.comparison(), options, options.coarse_dx_m.has_value());
  if (candidate.comparison.max_difference > options.shape_tolerance) {
    ladder.notes.push_back(fmt::format("the mode shapes of {} differ by {:.2g} %, above {:.2g} %",
                                       describe(rung.mesh),
                                       100.0 * candidate.comparison.max_difference,
                                       100.0 * options.shape_tolerance));
  }
  if (rung.modes.count() < options.num_modes) {
    ladder.notes.push_back(fmt::format("{} has only {} modes, {} are to be compared",
                                       describe(rung.mesh),
                                       rung.modes.count(),
                                       options.num_modes));
  }
  note_mixed_cells(tried, chosen, ladder);
  if (options.beside) {
    const bool plain = options.coarse_element == ElementKind::Hex8;
    ladder.beside =
        walk.run(candidate.dx_m, plain ? ElementKind::Hex8e : ElementKind::Hex8).candidate;
  }
  ladder.coarse = std::move(tried[chosen].rung);
}

}  // namespace twang
