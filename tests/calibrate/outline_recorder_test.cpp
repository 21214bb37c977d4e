// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/outline_recorder.hpp"

#include "tests/simulate/box_body.hpp"

#include <gtest/gtest.h>

namespace twang::test {
namespace {

using Eigen::VectorXd;

// A block that slides to the right by 1 mm a tenth of a second; nodes are floats in the drawing.
constexpr double kSpeed_m_s = 0.01;
constexpr float kRounding_m = 1e-8F;

class OutlineRecorderTest : public ::testing::Test {
 protected:
  /// Places as from `begin_s` to `end_s` in steps of a hundredth.
  void slide(double begin_s, double end_s) {
    constexpr double kStep_s = 0.01;
    for (double time_s = begin_s; time_s < end_s + 0.5 * kStep_s; time_s += kStep_s) {
      VectorXd u = VectorXd::Zero(m_mesh.num_dofs());
      for (int i = 0; i < m_mesh.num_nodes(); ++i) u[3 * i] = kSpeed_m_s * time_s;
      m_recorder.see(m_mesh, time_s, u);
    }
  }
  void expect_frames(std::size_t first, const std::vector<double>& times_s) const {
    const BodyDrawing& drawing = m_recorder.drawing();
    EXPECT_EQ(drawing.first_frame, first);
    ASSERT_EQ(drawing.corners.size(), times_s.size());
    for (std::size_t n = 0; n < times_s.size(); ++n) {
      const auto moved = static_cast<float>(kSpeed_m_s * times_s[n]);
      EXPECT_NEAR(drawing.corners[n].row(0).minCoeff(), moved, kRounding_m) << n;
      EXPECT_NEAR(drawing.corners[n].row(0).maxCoeff(), 0.02F + moved, kRounding_m) << n;
      // down is -z
      EXPECT_NEAR(drawing.corners[n].row(1).minCoeff(), -0.03F, kRounding_m) << n;
      EXPECT_NEAR(drawing.corners[n].row(1).maxCoeff(), 0.0F, kRounding_m) << n;
    }
  }

  HexMesh m_mesh = box_mesh(ElementKind::Hex8, {2, 3, 3}, {0.02, 0.01, 0.03});
  OutlineRecorder m_recorder = OutlineRecorder(Camera{}, {0.0, 0.021, 0.0475, 0.05, 0.2});
};

TEST_F(OutlineRecorderTest, SeesTheSurfaceAtTheTimesOfTheFrames) {
  slide(0.01, 0.06);
  expect_frames(1, {0.021, 0.0475, 0.05});
  // of 36 + 12 nodes and 18 + 24 faces; four nodes lie within
  EXPECT_EQ(m_recorder.drawing().faces.size(), 42U);
  EXPECT_EQ(m_recorder.drawing().corners.front().cols(), m_mesh.num_nodes() - 4);
}

TEST_F(OutlineRecorderTest, BeginsAnewWhenTheSimulationDoes) {
  slide(0.01, 0.06);
  slide(0.0, 0.03);
  expect_frames(0, {0.0, 0.021});
}

}  // namespace
}  // namespace twang::test
