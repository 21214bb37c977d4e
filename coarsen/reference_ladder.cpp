// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/ladder_steps.hpp"
#include "coarsen/detail/mesh_rung.hpp"
#include "coarsen/detail/richardson.hpp"
#include "core/error.hpp"
#include "fem/thinnest_wall.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

/// A third rung, which lets the order be observed although two are convergent, may cost at most
/// this share of max_dofs [-].
constexpr double kShareOfObservingRung = 0.4;
/// Meshes whose volumes agree this well stand for one geometry [-].
constexpr double kSameVolume = 1e-3;
constexpr int kStartAttempts = 8;

bool meshable(const Rig& rig, double dx_m) {
  try {
    (void)clamped_nodes(mesh_part(rig, dx_m, ElementKind::Hex8), rig);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

/// Largest relative difference of the first `count` frequencies, over those of `fine`.
double frequency_change(const Eigenmodes& coarse, const Eigenmodes& fine, int count) {
  double largest = coarse.count() < std::min(count, fine.count()) ? 1.0 : 0.0;
  for (int i = 0; i < std::min({count, coarse.count(), fine.count()}); ++i) {
    const double f = fine.natural_frequency_hz(i);
    largest = std::max(largest, std::abs(coarse.natural_frequency_hz(i) - f) / f);
  }
  return largest;
}

std::string percent(double fraction) { return fmt::format("{:.2g} %", 100.0 * fraction); }

/// Whether two meshes stand for one geometry.
bool same_geometry(const MeshRung& a, const MeshRung& b) {
  return std::abs(a.mesh.volume() / b.mesh.volume() - 1.0) <= kSameVolume;
}

void note_changing_geometry(MeshLadder& ladder) {
  const MeshRung& finest = ladder.reference.back();
  for (const MeshRung& rung : ladder.reference) {
    if (same_geometry(rung, finest)) continue;
    ladder.notes.push_back(
        fmt::format("the cells of {} do not fit the solids' edges: its volume is {} off that of "
                    "the finest mesh",
                    describe(rung.mesh),
                    percent(std::abs(rung.mesh.volume() / finest.mesh.volume() - 1.0))));
  }
}

}  // namespace

RichardsonLimit limit_of(const std::vector<MeshRung>& reference,
                         const std::vector<double>& lambdas_per_s2) {
  const std::size_t n = reference.size();
  std::size_t first = n - 1;
  while (first > 0 && same_geometry(reference[first - 1], reference.back())) --first;
  const std::vector<double> lambdas(lambdas_per_s2.begin() + static_cast<std::ptrdiff_t>(first),
                                    lambdas_per_s2.end());
  RichardsonLimit limit = richardson_limit(lambdas);
  if (lambdas.size() == 1 && n > 1) {
    const double before = lambdas_per_s2[n - 2];
    limit.relative_sigma = std::max(limit.relative_sigma, std::abs(before / lambdas[0] - 1.0));
  }
  return limit;
}

double starting_dx(const Rig& rig, const LadderOptions& options, std::vector<std::string>& notes) {
  double dx = 0.0;
  if (options.start_dx_m) {
    dx = *options.start_dx_m;
  } else {
    dx = thinnest_wall_m(rig);
    // Edges that do not fall on cell faces can let a solid slip between the cells' centres.
    for (int i = 0; i < kStartAttempts && !meshable(rig, dx); ++i) dx /= 2.0;
  }
  const double wanted = dx;
  long dofs = count_dofs(rig, dx, ElementKind::Hex20);
  const Box box = rig.bounding_box();
  while (dofs > options.max_dofs) {
    const double coarser = 2.0 * dx;
    if (coarser > (box.max - box.min).maxCoeff() || !meshable(rig, coarser)) {
      throw InputError(fmt::format(
          "the coarsest mesh that holds every solid of \"{}\" ({}) has {} unknowns, max_dofs is {}",
          rig.name,
          millimetres(dx),
          dofs,
          options.max_dofs));
    }
    dx = coarser;
    dofs = count_dofs(rig, dx, ElementKind::Hex20);
  }
  if (dx > wanted) {
    notes.push_back(
        fmt::format("the ladder starts at {} instead of {}: a finer mesh has more than {} unknowns",
                    millimetres(dx),
                    millimetres(wanted),
                    options.max_dofs));
  }
  return dx;
}

void refine_reference(const Rig& rig,
                      double start_dx_m,
                      const LadderOptions& options,
                      MeshLadder& ladder) {
  const int num_modes = std::max(options.num_frequencies, options.num_modes + 4);
  double change = 1.0;
  for (double dx = start_dx_m;; dx /= 2.0) {
    if (!ladder.reference.empty()) {
      ladder.convergent = change < options.convergent_change;
      if (ladder.convergent && ladder.reference.size() >= 3) break;
      const auto affordable =
          static_cast<double>(options.max_dofs) * (ladder.convergent ? kShareOfObservingRung : 1.0);
      if (static_cast<double>(count_dofs(rig, dx, ElementKind::Hex20)) > affordable) break;
    }
    ladder.reference.push_back(
        compute_rung(rig, dx, ElementKind::Hex20, num_modes, options.progress));
    const std::size_t n = ladder.reference.size();
    if (n >= 2) {
      change = frequency_change(
          ladder.reference[n - 2].modes, ladder.reference[n - 1].modes, options.num_modes);
    }
  }
  std::vector<double> lambdas;
  for (const MeshRung& rung : ladder.reference) lambdas.push_back(rung.modes.lambda_per_s2(0));
  ladder.limit = limit_of(ladder.reference, lambdas);
  note_changing_geometry(ladder);
  if (!ladder.convergent) {
    ladder.notes.push_back(
        ladder.reference.size() == 1
            ? fmt::format("only one reference mesh ({}) is affordable, its error is assumed",
                          describe(ladder.reference.back().mesh))
            : fmt::format("not convergent: halving dx to {} still changed a frequency by {}, the "
                          "next mesh has more than {} unknowns",
                          millimetres(ladder.reference.back().mesh.requested_dx_m),
                          percent(change),
                          options.max_dofs));
  }
  for (std::size_t i = 0; i < ladder.reference.size() && !ladder.accurate_rung; ++i) {
    const double from_finest = frequency_change(
        ladder.reference[i].modes, ladder.reference.back().modes, options.num_modes);
    if (from_finest < options.accurate_change) ladder.accurate_rung = static_cast<int>(i);
  }
}

}  // namespace twang
