// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/detail/ladder_steps.hpp"
#include "coarsen/detail/mesh_rung.hpp"
#include "coarsen/detail/richardson.hpp"
#include "core/error.hpp"
#include "fem/refine_mesh.hpp"
#include "fem/thinnest_wall.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace twang {
namespace {

/// A third rung, which lets the order be observed although two are convergent, may cost at most
/// this share of max_dofs [-].
constexpr double kShareOfObservingRung = 0.25;
/// Meshes whose volumes agree this well stand for one geometry [-].
constexpr double kSameVolume = 1e-3;
/// and a mesh of the part's volume to this is the part itself [-].
constexpr double kExactVolume = 1e-6;
constexpr int kStartAttempts = 8;
/// Unknowns of a mesh grow at least so many times where its cells are halved [-].
constexpr double kLeastGrowth = 3.0;
/// and at most so many times [-].
constexpr double kMostGrowth = 8.0;

bool meshable(const Rig& rig, double dx_m) {
  try {
    (void)clamped_nodes(mesh_part(rig, dx_m, ElementKind::Hex8), rig);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

/// The first of dx, dx / 2, ... that can be meshed.
/// @throws InputError, what is said of dx itself, if none can
double first_meshable(const Rig& rig, double dx_m) {
  for (int i = 0; i < kStartAttempts; ++i) {
    const double trial = std::ldexp(dx_m, -i);
    if (meshable(rig, trial)) return trial;
  }
  (void)clamped_nodes(mesh_part(rig, dx_m, ElementKind::Hex8), rig);
  return dx_m;
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

bool same_sequence(const MeshRung& a, const MeshRung& b) {
  return a.mesh.kind == b.mesh.kind && same_geometry(a, b);
}

bool has_mixed_cells(const Rig& rig, double dx_m) {
  return has_several_materials(rig) && count_mixed_cells(rig, dx_m).num_mixed > 0;
}

/// `dx_m` halved until no cell holds two materials; unchanged if no hex20 mesh of at most
/// `max_dofs` unknowns does that.
double without_mixed_cells(const Rig& rig,
                           double dx_m,
                           long max_dofs,
                           std::vector<std::string>& notes) {
  for (double dx = dx_m; count_dofs(rig, dx, ElementKind::Hex20) <= max_dofs; dx /= 2.0) {
    if (!has_mixed_cells(rig, dx)) return dx;
  }
  notes.push_back(fmt::format(
      "the borders of materials fall on cell faces neither at {} nor at halves of it, so that in "
      "the reference, too, cells are of the material at their centres",
      millimetres(dx_m)));
  return dx_m;
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

/// The limit of the last of the rungs up to number `last` that share its geometry and element.
/// Where others of the element do not share it, cells stand for the part by stairs, which may come
/// near it in volume and still stiffen with every halving: the last difference is the least that is
/// uncertain.
RichardsonLimit limit_at(const std::vector<MeshRung>& reference,
                         const std::vector<double>& all_lambdas,
                         std::size_t last) {
  std::size_t first = last;
  while (first > 0 && same_sequence(reference[first - 1], reference[last])) --first;
  std::vector<double> lambdas;
  for (std::size_t i = first; i <= last; ++i) lambdas.push_back(all_lambdas[i]);
  RichardsonLimit limit = richardson_limit(lambdas);
  const HexMesh& mesh = reference[last].mesh;
  const bool stairs = first > 0 && reference[first - 1].mesh.kind == mesh.kind &&
                      !(std::abs(mesh.volume() / mesh.part_volume_m3 - 1.0) <= kExactVolume);
  if (last > 0 && (stairs || first == last)) {
    const double before = all_lambdas[last - 1];
    const double change = std::abs(before / lambdas.back() - 1.0);
    limit.relative_sigma = std::max(limit.relative_sigma, change);
  }
  return limit;
}

/// Whether cells half as large make a mesh of at most `max_dofs` unknowns.
bool can_halve(const Rig& rig, const MeshRung& rung, ElementKind kind, double max_dofs) {
  if (rung.mesh.kind == kind && kLeastGrowth * rung.mesh.num_dofs() > max_dofs) return false;
  try {
    return static_cast<double>(count_dofs(rig, rung.mesh.requested_dx_m / 2.0, kind)) <= max_dofs;
  } catch (const InputError&) {  // more cells than a mesh may have
    return false;
  }
}

/// Adds rungs of one element that halve dx, until the frequencies stand or a mesh would have more
/// than `max_dofs` unknowns; returns the last change of a frequency.
double refine_with(const Rig& rig,
                   ElementKind kind,
                   double dx_m,
                   double max_dofs,
                   const LadderOptions& options,
                   MeshLadder& ladder) {
  const int num_modes = std::max(options.num_frequencies, options.num_modes + 4);
  const std::size_t first = ladder.reference.size();
  double change = 1.0;
  for (double dx = dx_m;; dx /= 2.0) {
    const std::size_t own = ladder.reference.size() - first;
    if (own > 0) {
      ladder.convergent = change < options.convergent_change;
      if (ladder.convergent && own >= 3) break;
      const double affordable = max_dofs * (ladder.convergent ? kShareOfObservingRung : 1.0);
      if (!can_halve(rig, ladder.reference.back(), kind, affordable)) break;
    }
    ladder.reference.push_back(compute_ladder_rung(rig, dx, kind, num_modes, options.progress));
    if (own > 0) {
      change = frequency_change(ladder.reference[first + own - 1].modes,
                                ladder.reference.back().modes,
                                options.num_modes);
    }
  }
  return change;
}

/// Where hex20 is not convergent, hex8e goes on from its finest cells, if it can halve them.
double refine_on(const Rig& rig, double change, const LadderOptions& options, MeshLadder& ladder) {
  const MeshRung& last = ladder.reference.back();
  const double max_dofs = options.enhanced_growth * static_cast<double>(options.max_dofs);
  if (!can_halve(rig, last, ElementKind::Hex8e, max_dofs)) return change;
  const double dx_m = last.mesh.requested_dx_m;
  return refine_with(rig, ElementKind::Hex8e, dx_m, max_dofs, options, ladder);
}

/// Limit, notes and the accurate rung of a reference that stands.
void conclude(double change, const LadderOptions& options, MeshLadder& ladder) {
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
                          "next mesh is too large",
                          describe(ladder.reference.back().mesh),
                          percent(change)));
  }
  for (std::size_t i = 0; i < ladder.reference.size() && !ladder.accurate_rung; ++i) {
    const double from_finest = frequency_change(
        ladder.reference[i].modes, ladder.reference.back().modes, options.num_modes);
    if (from_finest < options.accurate_change) ladder.accurate_rung = static_cast<int>(i);
  }
}

}  // namespace

RichardsonLimit limit_of(const std::vector<MeshRung>& reference,
                         const std::vector<double>& lambdas_per_s2) {
  const std::size_t finest = reference.size() - 1;
  RichardsonLimit limit = limit_at(reference, lambdas_per_s2, finest);
  for (std::size_t i = finest; i-- > 0;) {
    if (reference[i].mesh.kind == reference[finest].mesh.kind) continue;
    const RichardsonLimit other = limit_at(reference, lambdas_per_s2, i);
    const bool better = other.relative_sigma < limit.relative_sigma;
    return better && same_geometry(reference[i], reference[finest]) ? other : limit;
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
    dx = first_meshable(rig, dx);
  }
  if (has_several_materials(rig)) dx = without_mixed_cells(rig, dx, options.max_dofs, notes);
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
    notes.push_back(fmt::format(
        "the ladder starts at {} instead of {}: a finer hex20 mesh has more than {} unknowns",
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
  double change = refine_with(
      rig, ElementKind::Hex20, start_dx_m, static_cast<double>(options.max_dofs), options, ladder);
  if (!ladder.convergent) change = refine_on(rig, change, options, ladder);
  conclude(change, options, ladder);
}

void refine_file_reference(const Rig& rig,
                           HexMesh mesh,
                           const LadderOptions& options,
                           MeshLadder& ladder) {
  const int num_modes = std::max(options.num_frequencies, options.num_modes + 4);
  if (mesh.num_dofs() > options.max_dofs) {
    ladder.notes.push_back(fmt::format(
        "the mesh file has {} unknowns as hex20, above {}", mesh.num_dofs(), options.max_dofs));
  }
  double change = 1.0;
  ladder.reference.push_back(
      compute_ladder_rung(rig, std::move(mesh), num_modes, options.progress));
  while (!ladder.convergent && kMostGrowth * ladder.reference.back().mesh.num_dofs() <=
                                   static_cast<double>(options.max_dofs)) {
    ladder.reference.push_back(compute_ladder_rung(
        rig, refine_uniformly(ladder.reference.back().mesh), num_modes, options.progress));
    const std::size_t n = ladder.reference.size();
    change = frequency_change(
        ladder.reference[n - 2].modes, ladder.reference[n - 1].modes, options.num_modes);
    ladder.convergent = change < options.convergent_change;
  }
  conclude(change, options, ladder);
}

}  // namespace twang
