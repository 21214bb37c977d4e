// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/outline_recorder.hpp"

#include "capture/find_layout.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <map>
#include <utility>

namespace twang {

OutlineRecorder::OutlineRecorder(const Camera& camera, std::vector<double> frame_time_s)
    : m_camera(camera), m_frame_time_s(std::move(frame_time_s)) {}

void OutlineRecorder::begin(const HexMesh& mesh, double time_s) {
  m_drawing = {};
  m_nodes.clear();
  m_corners.resize(2, 0);
  std::map<int, int> number_of;
  for (std::array<int, 4> face : surface_faces(mesh)) {
    for (int& corner : face) {
      const auto [at, is_new] = number_of.emplace(corner, static_cast<int>(m_nodes.size()));
      if (is_new) m_nodes.push_back(corner);
      corner = at->second;
    }
    m_drawing.faces.push_back(face);
  }
  const auto first = std::lower_bound(m_frame_time_s.begin(), m_frame_time_s.end(), time_s);
  m_next = static_cast<std::size_t>(first - m_frame_time_s.begin());
  m_drawing.first_frame = m_next;
}

void OutlineRecorder::see(const HexMesh& mesh, double time_s, const Eigen::VectorXd& u) {
  const bool starts = m_corners.cols() == 0 || time_s < m_time_s;
  if (starts) begin(mesh, time_s);
  Eigen::Matrix2Xd corners(2, static_cast<Eigen::Index>(m_nodes.size()));
  for (std::size_t i = 0; i < m_nodes.size(); ++i) {
    const Eigen::Vector3d place = mesh.nodes.col(m_nodes[i]) + u.segment<3>(3 * m_nodes[i]);
    corners.col(static_cast<Eigen::Index>(i)) = plane_position(m_camera, place);
  }
  if (starts) {
    m_corners = corners;
    m_time_s = time_s;
  }
  for (; m_next < m_frame_time_s.size() && m_frame_time_s[m_next] <= time_s; ++m_next) {
    const double over = time_s - m_time_s;
    const double share = over > 0.0 ? (m_frame_time_s[m_next] - m_time_s) / over : 1.0;
    m_drawing.corners.emplace_back(((1.0 - share) * m_corners + share * corners).cast<float>());
  }
  m_corners = std::move(corners);
  m_time_s = time_s;
}

}  // namespace twang
