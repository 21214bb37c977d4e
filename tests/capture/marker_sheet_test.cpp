// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/marker_sheet.hpp"

#include "capture/align_marker.hpp"
#include "capture/find_layout.hpp"
#include "capture/marker_pattern.hpp"
#include "core/constants.hpp"
#include "core/units.hpp"
#include "tests/support/expect_refusal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <sstream>

namespace twang::test {
namespace {

struct InkCircle {
  double x, y, inner, outer;  // [mm]
};
struct InkRectangle {
  double x0, y0, x1, y1;  // [mm]
};

/// The ink of a page, read back from its SVG as another program would.
struct PageInk {
  std::vector<InkCircle> circles;
  std::vector<InkRectangle> rectangles;

  [[nodiscard]] bool at(double x, double y) const {
    for (const InkCircle& circle : circles) {
      const double r = std::hypot(x - circle.x, y - circle.y);
      if (r >= circle.inner && r < circle.outer) return true;
    }
    for (const InkRectangle& box : rectangles) {
      if (x >= box.x0 && x < box.x1 && y >= box.y0 && y < box.y1) return true;
    }
    return false;
  }
};

double attribute(const std::string& element, const std::string& name) {
  std::smatch match;
  std::string expression = "\\b";
  expression.append(name).append("=\"([-0-9.e]+)\"");
  const std::regex pattern(expression);
  if (!std::regex_search(element, match, pattern)) return kNaN;
  return std::stod(match[1]);
}

PageInk read_page(const std::string& svg) {
  PageInk ink;
  const std::regex shape("<(circle|path) class=\"(ink|ring)\"[^>]*>");
  const std::regex corner("M([-0-9.e]+) ([-0-9.e]+)h([-0-9.e]+)v([-0-9.e]+)");
  for (std::sregex_iterator it(svg.begin(), svg.end(), shape), end; it != end; ++it) {
    const std::string element = it->str();
    if ((*it)[1] == "circle") {
      const double half = (*it)[2] == "ring" ? 0.5 * attribute(element, "stroke-width") : kNaN;
      const double r = attribute(element, "r");
      ink.circles.push_back({attribute(element, "cx"),
                             attribute(element, "cy"),
                             std::isnan(half) ? 0.0 : r - half,
                             std::isnan(half) ? r : r + half});
      continue;
    }
    for (std::sregex_iterator c(element.begin(), element.end(), corner); c != end; ++c) {
      const double x = std::stod((*c)[1]);
      const double y = std::stod((*c)[2]);
      ink.rectangles.push_back({x, y, x + std::stod((*c)[3]), y + std::stod((*c)[4])});
    }
  }
  return ink;
}

Marker marker_of(const std::string& id, MarkerKind kind, double size_mm) {
  Marker marker;
  marker.id = id;
  marker.kind = kind;
  marker.size_m = size_mm * kMetresPerMillimetre;
  return marker;
}

Rig rig_of(const std::vector<Marker>& markers) {
  Rig rig;
  rig.name = "a <rig> & \"more\"";
  rig.markers = markers;
  return rig;
}

const std::vector<Marker> kOneOfEach = {marker_of("a cross", MarkerKind::Cross, 10.0),
                                        marker_of("a dot", MarkerKind::Dot, 8.0),
                                        marker_of("a ring", MarkerKind::Ring, 12.0),
                                        marker_of("a checker", MarkerKind::Checker, 9.0)};

TEST(MarkerSheet, PrintsThePatternsTrueToScale) {
  const Rig rig = rig_of(kOneOfEach);
  const MarkerSheet sheet = draw_marker_sheet(rig);
  ASSERT_EQ(sheet.pages.size(), 1U);
  ASSERT_EQ(sheet.markers.size(), 4U);
  const std::string& svg = sheet.pages.front();
  EXPECT_NE(svg.find("width=\"210mm\" height=\"297mm\" viewBox=\"0 0 210 297\""),
            std::string::npos);
  const PageInk page = read_page(svg);
  for (std::size_t i = 0; i < rig.markers.size(); ++i) {
    const MarkerPattern pattern(rig.markers[i]);
    const double size = rig.markers[i].size_m * kMillimetresPerMetre;
    const double x = sheet.markers[i].centre_x_m * kMillimetresPerMetre;
    const double y = sheet.markers[i].centre_y_m * kMillimetresPerMetre;
    int differ = 0;
    constexpr int kSteps = 150;
    // out to the edge of the paper, a quarter of the size beyond the ink
    for (int row = 0; row < kSteps; ++row) {
      for (int column = 0; column < kSteps; ++column) {
        const double u = 1.5 * ((column + 0.5) / kSteps - 0.5);
        const double v = 1.5 * ((row + 0.5) / kSteps - 0.5);
        differ += page.at(x + u * size, y + v * size) != (pattern.value(u, v) < 0.5);
      }
    }
    // the SVG's four decimals move an edge by 5e-5 mm: no point of the grid lies that near one
    EXPECT_EQ(differ, 0) << rig.markers[i].id;
  }
}

TEST(MarkerSheet, IsFoundByTheTracker) {
  Rig rig = rig_of(kOneOfEach);
  const MarkerSheet sheet = draw_marker_sheet(rig);
  const PageInk page = read_page(sheet.pages.front());
  rig.camera = Camera{};
  for (std::size_t i = 0; i < rig.markers.size(); ++i) {
    rig.markers[i].fixed = true;
    rig.markers[i].position = {sheet.markers[i].centre_x_m, 0.0, -sheet.markers[i].centre_y_m};
  }
  // the upper 60 mm of the page, three pixels a millimetre
  constexpr int kScale = 3;
  constexpr int kFiner = 8;
  Image image{210 * kScale, 60 * kScale, 1, {}};
  for (int y = 0; y < image.height_px; ++y) {
    for (int x = 0; x < image.width_px; ++x) {
      int inked = 0;
      for (int k = 0; k < kFiner * kFiner; ++k) {
        inked += page.at((x + (k % kFiner + 0.5) / kFiner) / kScale,
                         (y + (k / kFiner + 0.5) / kFiner) / kScale);
      }
      image.pixels.push_back(static_cast<std::uint8_t>(230 - 200 * inked / (kFiner * kFiner)));
    }
  }
  const Layout layout = find_layout(luma_view(image), rig);
  ASSERT_EQ(layout.markers.size(), rig.markers.size());
  for (std::size_t i = 0; i < rig.markers.size(); ++i) {
    const Eigen::Vector2d expected_px =
        Eigen::Vector2d(sheet.markers[i].centre_x_m, sheet.markers[i].centre_y_m) *
            kMillimetresPerMetre * kScale -
        Eigen::Vector2d::Constant(0.5);
    const MarkerPlacement& found = layout.markers[i].alignment.placement;
    // eight samples along a pixel put an edge wrong by at most a sixteenth of it
    EXPECT_LT((found.position_px - expected_px).norm(), 1.0 / 16.0) << rig.markers[i].id;
    EXPECT_NEAR(placed_size_px(found), rig.markers[i].size_m * 1e3 * kScale, 0.5)
        << rig.markers[i].id;
  }
}

TEST(MarkerSheet, KeepsItsMarkersApartAndOnThePage) {
  std::vector<Marker> markers;
  for (int i = 0; i < 60; ++i) {
    markers.push_back(marker_of(std::to_string(i), MarkerKind::Dot, 10.0 + 5.0 * (i % 5)));
  }
  const MarkerSheet sheet = draw_marker_sheet(rig_of(markers));
  ASSERT_EQ(sheet.markers.size(), markers.size());
  EXPECT_GT(sheet.pages.size(), 1U);
  for (std::size_t i = 0; i < markers.size(); ++i) {
    const PrintedMarker& a = sheet.markers[i];
    const double half = 0.75 * markers[i].size_m;
    EXPECT_GE(a.centre_x_m - half, 0.0119);
    EXPECT_LE(a.centre_x_m + half, 0.1981);
    EXPECT_LE(a.centre_y_m + half, 0.2651);
    for (std::size_t j = 0; j < i; ++j) {
      const PrintedMarker& b = sheet.markers[j];
      if (a.page != b.page) continue;
      const double apart =
          std::max(std::abs(a.centre_x_m - b.centre_x_m), std::abs(a.centre_y_m - b.centre_y_m));
      EXPECT_GE(apart, half + 0.75 * markers[j].size_m) << a.id << ", " << b.id;
    }
  }
}

TEST(MarkerSheet, EscapesNamesAndLeavesPatchesOut) {
  Rig rig =
      rig_of({marker_of("a<b", MarkerKind::Dot, 5.0), marker_of("wood", MarkerKind::Patch, 9.0)});
  const MarkerSheet sheet = draw_marker_sheet(rig);
  EXPECT_NE(sheet.pages[0].find("a&lt;b: dot, 5 mm"), std::string::npos);
  EXPECT_NE(sheet.pages[0].find("a &lt;rig&gt; &amp; &quot;more&quot;"), std::string::npos);
  EXPECT_EQ(sheet.pages[0].find("a<b"), std::string::npos);
  EXPECT_EQ(sheet.not_printed, (std::vector<std::string>{"wood"}));
}

TEST(MarkerSheet, RefusesWhatCannotBePrinted) {
  EXPECT_TRUE(holds(refusal_of([] {
                      (void)draw_marker_sheet(rig_of({marker_of("big", MarkerKind::Dot, 150.0)}));
                    }),
                    "marker 'big' is 150 mm, must be at most 124 mm"));
  EXPECT_TRUE(
      holds(refusal_of([] { (void)draw_marker_sheet(rig_of({})); }), "has no marker to print"));
}

}  // namespace
}  // namespace twang::test
