// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "calibrate/marker_motion.hpp"
#include "coarsen/mesh_ladder.hpp"
#include "core/constants.hpp"
#include "core/damped_sinusoid.hpp"
#include "rigs/rig.hpp"

#include <optional>
#include <string>
#include <vector>

namespace twang {

/// Which eigenmode is it that was recorded?
struct ModeQuestion {
  const Rig* rig = nullptr;
  const MeshRung* rung = nullptr;         ///< a fine mesh, its unknown modulus 1 Pa
  std::vector<DampedSinusoid> sinusoids;  ///< of the signal, strongest first; at least one
  std::vector<std::string> columns;       ///< of the trace that were inverted
  std::vector<MarkerMotion> motion;       ///< of the strongest; may be empty
  std::optional<double> reported_modulus_pa;
  std::optional<int> stated;  ///< the mode the user says it is, from 0
};

/// What speaks for one eigenmode.
struct ModeCandidate {
  int mode = 0;             ///< of the mesh, from 0
  double share = 0.0;       ///< how much it moves what was inverted, at equal energy, over the most
                            ///< that any mode does [-]
  double modulus_pa = 0.0;  ///< E, if it is this one [Pa]
  double motion = kNaN;     ///< correlation of the markers' motion with its shape, 0 to 1 [-]
  int explained = 0;        ///< further sinusoids that are then modes of the mesh
  double prior = 0.0;       ///< ln of how likely a pluck shows it most [-]
  double evidence = 0.0;    ///< ln of how likely what was seen then is [-]
  [[nodiscard]] double score() const { return prior + evidence; }
};

struct ModeChoice {
  int mode = 0;                           ///< of the mesh, from 0
  bool stated = false;                    ///< by the user
  std::string reason;                     ///< which and why, one sentence
  std::string doubt;                      ///< what speaks for another, one sentence; may be empty
  std::vector<ModeCandidate> candidates;  ///< those the columns can see, ascending
};

/// Takes the strongest sinusoid for the eigenmode that explains best what was recorded, as
///
///     score = ln of the prior + ln of the evidence,
///
/// of which the prior is the square of a mode's share in the inverted columns at equal energy (a
/// pluck rings lowest modes most), and the evidence
///
/// - the ratios of the further sinusoids' natural frequencies to the strongest's, against the
///   mesh's, which do not depend on the modulus;
/// - the pattern in which the strongest moves the markers in the picture, against the shapes;
/// - weakly, the distance of the modulus that follows from the reported one.
///
/// Modes that move the columns by less than a fiftieth of what the most visible one does are no
/// candidates. Modes within two per cent of frequency of one another count as one. Columns that
/// are neither the observable nor a marker's see every mode.
/// @throws InputError if the stated mode is none of the mesh
[[nodiscard]] ModeChoice choose_mode(const ModeQuestion& question);

}  // namespace twang
