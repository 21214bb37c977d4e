// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/outline_overlay.hpp"
#include "fem/hex_mesh.hpp"
#include "rigs/rig.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <optional>
#include <vector>

namespace twang {

/// Takes down how a simulated mesh looks to the rig's camera at the times of a film's frames.
class OutlineRecorder {
 public:
  /// @param frame_time_s  of each frame of the film, ascending [s]
  OutlineRecorder(const Camera& camera, std::vector<double> frame_time_s);

  /// A state of the simulation, linearly between which and the one before frames are taken; a time
  /// before the last one begins anew.
  void see(const HexMesh& mesh, double time_s, const Eigen::VectorXd& u);

  /// What was seen of the frames within the simulated time, `map` and `name` left empty.
  [[nodiscard]] const BodyDrawing& drawing() const { return m_drawing; }

 private:
  void begin(const HexMesh& mesh, double time_s);

  Camera m_camera;
  std::vector<double> m_frame_time_s;
  std::vector<int> m_nodes;  // that are seen
  BodyDrawing m_drawing;
  std::size_t m_next = 0;  // frame
  double m_time_s = 0.0;   // of m_corners
  Eigen::Matrix2Xd m_corners;
};

}  // namespace twang
