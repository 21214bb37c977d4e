// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/progress.hpp"
#include "fem/eigenmodes.hpp"
#include "fem/hex_mesh.hpp"
#include "rigs/rig.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace twang {

/// The eigenmodes of one mesh of a rig, with Young's modulus 1 Pa in the unknown material [paper,
/// §3.2].
struct MeshRung {
  HexMesh mesh;
  std::vector<int> held_nodes;
  Eigenmodes modes;
  double seconds = 0.0;  ///< wall time spent [s]
};

struct LadderOptions {
  std::optional<double> start_dx_m;  ///< absent: the thinnest wall of the rig's solids, halved
                                     ///< until every solid and clamp is caught [m]
  double convergent_change = 0.01;   ///< frequencies change by less on halving dx: convergent [-]
  double accurate_change = 0.05;  ///< frequencies within this of the convergent mesh: accurate [-]
  double shape_tolerance = 0.05;  ///< mode distance up to which a coarser mesh is taken [-]
  int num_modes = 4;              ///< dominant modes whose shapes must agree
  int num_frequencies = 10;       ///< modes computed and reported
  long max_dofs = 450000;         ///< unknowns the hex20 reference may reach; a start above it is
                                  ///< coarsened
  std::optional<double> coarse_dx_m;  ///< the coarse mesh wanted, compared all the same; absent:
                                      ///< chosen [m]
  ProgressCallback progress = {};
  ElementKind coarse_element = ElementKind::Hex8;  ///< of the coarse mesh: hex8 or hex8e
  double enhanced_growth = 4.0;  ///< hex8e goes on where hex20 ends before it is convergent, up to
                                 ///< so many times max_dofs; 0: not at all [-]
  bool beside = false;           ///< compare the other element on the cells chosen, too
  void check() const;
};

/// The limit of a sequence of meshes.
struct RichardsonLimit {
  double lambda_per_s2 = 0.0;   ///< of mode 1, at E = 1 Pa [1/s²]
  double relative_sigma = 0.0;  ///< of lambda: what the mesh leaves uncertain [-]
  double order = 0.0;  ///< observed (three rungs) or assumed (two) order in dx of lambda [-]
  bool order_observed = false;
};

/// How far the modes of a coarser mesh are from those of the finer one.
struct ModeComparison {
  double max_difference =
      0.0;  ///< largest pointwise difference over the peak, worst of the compared modes [-]
  double hausdorff = 0.0;  ///< the paper's set distance of the surfaces deflected to a peak of a
                           ///< tenth of the part's largest dimension, over that peak [-]
  std::vector<double> difference_by_mode;
  std::vector<double> hausdorff_by_mode;
};

/// One coarse candidate beside the reference.
struct CoarseCandidate {
  double dx_m = 0.0;
  int num_elements = 0;
  Eigen::VectorXd natural_frequency_hz;  ///< at E = 1 Pa [Hz]
  ModeComparison comparison;
  bool passes = false;
  double mean_frequency_error_before = 0.0;  ///< of num_frequencies modes against the reference [-]
  double mean_frequency_error_after = 0.0;   ///< the same after the rescale of eq. (15) [-]
  ElementKind element = ElementKind::Hex8;
  double rescale = 1.0;      ///< of frequencies by eq. (15): the first becomes the reference's [-]
  long num_mixed_cells = 0;  ///< that hold more than one material
  /// For each mode of the finest reference mesh the number of the one of its shape, from 0.
  std::vector<int> mode_of_reference;
};

/// The reference ladder (hex20, then hex8e, with Richardson on top) and the coarse mesh (hex8 or
/// hex8e) chosen below it [DAC, paper §3.1].
struct MeshLadder {
  std::vector<MeshRung> reference;  ///< coarse to fine; hex8e, if any, begins where hex20 ended
  RichardsonLimit limit;
  bool convergent = false;  ///< the finest rung changed by less than convergent_change
  std::optional<int>
      accurate_rung;  ///< coarsest rung of `reference` within accurate_change of the finest
  std::vector<CoarseCandidate> candidates;  ///< fine to coarse
  MeshRung coarse;                          ///< the one chosen
  std::string choice;                       ///< one sentence: why this one
  std::vector<std::string> notes;
  bool stated_moduli =
      false;  ///< eigenvalues belong to the moduli that the rig states, not to 1 Pa
  std::optional<CoarseCandidate> beside;  ///< the other element on the cells of `coarse`, if wanted
  std::size_t num_reference_notes = 0;    ///< the first of `notes`, which are not of the choice
  double start_dx_m = 0.0;                ///< about which the walk among coarse meshes begins [m]

  /// The candidate that `coarse` is.
  [[nodiscard]] const CoarseCandidate& chosen() const;
  /// E / E_n = lambda_1 of the coarse mesh over that of the limit [paper, eq. (15)] [-].
  [[nodiscard]] double identified_over_numerical() const;
  /// Cell size of the coarsest accurate hex20 mesh of the reference, else of its finest hex20 mesh:
  /// that for `modulus_sensitivities` [m].
  [[nodiscard]] double sensitivity_dx_m() const;
};

/// Walks the ladder: refines hex20 by halving dx until the frequencies stand, then coarsens hex8 or
/// hex8e as long as the dominant mode shapes agree.
///
/// Where hex20 has not converged at max_dofs, hex8e goes on from its last cells, by multigrid once
/// a factor is too large. A third reference rung is added to two convergent ones where it costs
/// little, so that the order is observed. Shapes are compared with the finest accurate rung that is
/// not large (`choice` names it). If no coarse mesh keeps the shapes, the finest tried is taken and
/// a note says so.
///
/// A modulus that the rig states takes no part if the part has one material. With several, all are
/// stated: then only their ratios count, and a mesh with cells that more than one of them shares is
/// not chosen; `notes` say where that ends the coarsening.
///
/// Of a part that is a mesh file that mesh as hex20 is the reference, and refined by cutting its
/// elements into eight; coarse meshes are voxels of its outside.
///
/// @throws InputError if the rig lacks part or clamp, if the part has several materials of which
/// one states no modulus, or if no mesh of at most max_dofs unknowns holds every solid; Cancelled;
/// NumericalFailure if an eigenproblem cannot be solved
[[nodiscard]] MeshLadder build_mesh_ladder(const Rig& rig, const LadderOptions& options = {});

/// The reference ladder alone, without a coarse mesh.
/// @throws as `build_mesh_ladder`
[[nodiscard]] MeshLadder build_reference_ladder(const Rig& rig, const LadderOptions& options = {});

/// Chooses the coarse mesh of a ladder anew, its reference kept: another element, tolerance or
/// number of modes, or another cell size wanted.
/// @param options  as `build_mesh_ladder`; those of the reference play no role
[[nodiscard]] MeshLadder choose_again(const Rig& rig,
                                      MeshLadder ladder,
                                      const LadderOptions& options);

/// Mesh, held nodes and the first `num_modes` eigenmodes of a rig (fewer if the mesh has not that
/// many), its weights included, at its stated Young's moduli, else 1 Pa. A rig without clamps is a
/// free body.
/// @throws InputError if the part or a clamp vanishes at this dx; NumericalFailure if the
/// eigenproblem fails; Cancelled
[[nodiscard]] MeshRung compute_rung(const Rig& rig,
                                    double dx_m,
                                    ElementKind kind,
                                    int num_modes,
                                    const ProgressCallback& progress = {});

/// A rig whose part is a mesh file with that mesh's outside as its solids, for voxels; any other as
/// it is.
/// @throws InputError if the mesh file cannot be read
[[nodiscard]] Rig as_solids(const Rig& rig);

/// The materials of `mesh` as the eigenproblem wants them: the rig's stated Young's modulus, else
/// `unknown_modulus_pa`.
[[nodiscard]] std::vector<ElasticMaterial> elastic_materials(const Rig& rig,
                                                             const HexMesh& mesh,
                                                             double unknown_modulus_pa = 1.0);

/// Distance of the first `num_modes` mode shapes of two meshes of one part.
///
///     u  a fine mode on the fine surface,  C  the coarse modes that stand for it, there
///     p = C argmin ‖u - C c‖, scaled to max |p| = max |u|
///     difference = max |u - p| / max |u|
///
/// Partners are found by shape, not by number: as many coarse modes as the fine mode has of near
/// equal frequency (itself included), those that lie most nearly in the span of these, and whatever
/// coarse modes share their frequencies. Points outside the coarse mesh move with its nearest
/// element. Both meshes are voxel meshes.
[[nodiscard]] ModeComparison compare_modes(const MeshRung& fine,
                                           const MeshRung& coarse,
                                           int num_modes);

}  // namespace twang
