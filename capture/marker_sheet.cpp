// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/marker_sheet.hpp"

#include "capture/marker_pattern.hpp"
#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

// All lengths here are millimetres: those of the page.
constexpr double kPageWidth = 210.0;
constexpr double kPageHeight = 297.0;
constexpr double kBorder = 12.0;   // printers leave some of it white
constexpr double kTop = 30.0;      // of the markers, below the heading
constexpr double kBottom = 265.0;  // of the markers, above the ruler
constexpr double kRulerHeight = 280.0;
constexpr double kRuler = 100.0;
constexpr double kGap = 5.0;            // between tiles
constexpr double kLetters = 3.0;        // size of the font
constexpr double kLetterWidth = 0.6;    // of that size: a wide letter
constexpr double kLabel = 5.0;          // room for a name below a marker
constexpr double kPaperOverSize = 1.5;  // a quarter of the size white all around

std::string number(double millimetres) {
  const double rounded = std::round(millimetres * 1e4) / 1e4;
  return fmt::format("{:.7g}", rounded == 0.0 ? 0.0 : rounded);
}

std::string rectangle(double x, double y, double width, double height) {
  return fmt::format(
      "M{} {}h{}v{}h{}z", number(x), number(y), number(width), number(height), number(-width));
}

/// The ink of a tag: the runs of each row, in one path so that no seam shows between them.
std::string tag_path(const MarkerPattern& pattern, double x, double y, double size) {
  const int cells = pattern.num_cells();
  const double cell = size / cells;
  std::string path;
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells; ++column) {
      if (!pattern.ink(row, column)) continue;
      const int first = column;
      while (column + 1 < cells && pattern.ink(row, column + 1)) ++column;
      path += rectangle(x + first * cell, y + row * cell, (column + 1 - first) * cell, cell);
    }
  }
  return path;
}

/// The ink of a marker whose outer square begins at (x, y).
std::string marker_shape(const Marker& marker, double x, double y) {
  const double size = marker.size_m * kMillimetresPerMetre;
  const double third = size / 3.0;
  const std::string middle =
      fmt::format("cx=\"{}\" cy=\"{}\"", number(x + 0.5 * size), number(y + 0.5 * size));
  const auto path = [](const std::string& d) {
    return fmt::format("<path class=\"ink\" d=\"{}\"/>\n", d);
  };
  switch (marker.kind) {
    case MarkerKind::Cross:
      return path(rectangle(x, y + third, size, third) + rectangle(x + third, y, third, size));
    case MarkerKind::Dot:
      return fmt::format("<circle class=\"ink\" {} r=\"{}\"/>\n", middle, number(0.5 * size));
    case MarkerKind::Ring:
      return fmt::format("<circle class=\"ring\" {} r=\"{}\" stroke-width=\"{}\"/>\n",
                         middle,
                         number(0.375 * size),
                         number(0.25 * size));
    case MarkerKind::Checker:
      return path(rectangle(x, y, 0.5 * size, 0.5 * size) +
                  rectangle(x + 0.5 * size, y + 0.5 * size, 0.5 * size, 0.5 * size));
    case MarkerKind::ArUco:
    case MarkerKind::AprilTag:
      return path(tag_path(MarkerPattern(marker), x, y, size));
    case MarkerKind::Patch:
      break;
  }
  return {};
}

std::string label_of(const Marker& marker) {
  const double size = marker.size_m * kMillimetresPerMetre;
  return marker.tag >= 0
             ? fmt::format("{}: {} {}, {:.4g} mm", marker.id, marker.dictionary, marker.tag, size)
             : fmt::format("{}: {}, {:.4g} mm", marker.id, to_string(marker.kind), size);
}

/// The marker on its paper, the paper's upper left corner at (x, y).
std::string tile(const Marker& marker, double x, double y) {
  const double size = marker.size_m * kMillimetresPerMetre;
  const double paper = kPaperOverSize * size;
  const double margin = 0.5 * (paper - size);
  return fmt::format("<g>\n<title>{}</title>\n{}",
                     escape_xml(marker.id),
                     marker_shape(marker, x + margin, y + margin)) +
         fmt::format("<path class=\"cut\" d=\"{}\"/>\n", rectangle(x, y, paper, paper)) +
         fmt::format("<text x=\"{}\" y=\"{}\">{}</text>\n</g>\n",
                     number(x),
                     number(y + paper + 0.75 * kLabel),
                     escape_xml(label_of(marker)));
}

std::string ruler() {
  std::string lines =
      fmt::format("M{} {}h{}", number(kBorder), number(kRulerHeight), number(kRuler));
  for (int mm = 0; mm <= static_cast<int>(kRuler); ++mm) {
    const double length = mm % 10 == 0 ? 4.0 : mm % 5 == 0 ? 3.0 : 2.0;
    lines += fmt::format("M{} {}v{}", number(kBorder + mm), number(kRulerHeight), number(-length));
  }
  return fmt::format(
      "<path class=\"ruler\" d=\"{}\"/>\n"
      "<text x=\"{}\" y=\"{}\">100 mm: if this is not 100 mm long on paper, print again at 100 % "
      "scale</text>\n",
      lines,
      number(kBorder),
      number(kRulerHeight + 5.0));
}

std::string page(const std::string& rig_name, int number_of, int count, const std::string& tiles) {
  return fmt::format(
             "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}mm\" height=\"{1}mm\" "
             "viewBox=\"0 0 {0} {1}\">\n"
             "<title>{2}, markers, page {3} of {4}</title>\n"
             "<style>.ink{{fill:#000}}.ring{{fill:none;stroke:#000}}"
             ".cut{{fill:none;stroke:#aaa;stroke-width:0.1}}"
             ".ruler{{fill:none;stroke:#000;stroke-width:0.15}}"
             "text{{font-family:sans-serif;font-size:{5}px;fill:#000}}"
             ".head{{font-size:5px}}</style>\n"
             "<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n",
             number(kPageWidth),
             number(kPageHeight),
             escape_xml(rig_name),
             number_of,
             count,
             number(kLetters)) +
         fmt::format("<text class=\"head\" x=\"{}\" y=\"{}\">{}</text>\n",
                     number(kBorder),
                     number(kBorder + 5.0),
                     escape_xml(rig_name)) +
         fmt::format(
             "<text x=\"{}\" y=\"{}\">Markers, page {} of {}. Print on matt white paper, cut "
             "along the thin lines, glue with the name's side down as seen in the "
             "film.</text>\n",
             number(kBorder),
             number(kBorder + 11.0),
             number_of,
             count) +
         tiles + ruler() + "</svg>\n";
}

/// Puts tiles into lines and lines onto pages, in order.
class PageFiller {
 public:
  struct Place {
    int page;
    double x;
    double y;
  };
  Place place(double width, double height) {
    if (m_x > kBorder && m_x + width > kPageWidth - kBorder) end_line();
    if (m_y > kTop && m_y + height > kBottom) {
      end_line();
      ++m_page;
      m_y = kTop;
    }
    const Place place{m_page, m_x, m_y};
    m_x += width + kGap;
    m_line_height = std::max(m_line_height, height);
    return place;
  }

 private:
  void end_line() {
    m_y += m_line_height + kGap;
    m_x = kBorder;
    m_line_height = 0.0;
  }
  int m_page = 0;
  double m_x = kBorder;
  double m_y = kTop;
  double m_line_height = 0.0;
};

}  // namespace

MarkerSheet draw_marker_sheet(const Rig& rig) {
  const std::string name = rig.file.empty() ? "rig '" + rig.name + "'" : rig.file.string();
  const double largest =
      std::min(kPageWidth - 2.0 * kBorder, kBottom - kTop - kLabel) / kPaperOverSize;
  MarkerSheet sheet;
  std::vector<std::string> tiles;
  PageFiller filler;
  for (const Marker& marker : rig.markers) {
    if (marker.kind == MarkerKind::Patch) {
      sheet.not_printed.push_back(marker.id);
      continue;
    }
    const double size = marker.size_m * kMillimetresPerMetre;
    if (size > largest) {
      throw InputError(
          fmt::format("{}: marker '{}' is {:.4g} mm, must be at most {:.4g} mm to fit on a page "
                      "with its margin",
                      name,
                      marker.id,
                      size,
                      largest));
    }
    const double paper = kPaperOverSize * size;
    const double letters = kLetterWidth * kLetters * static_cast<double>(label_of(marker).size());
    const PageFiller::Place place = filler.place(std::max(paper, letters), paper + kLabel);
    if (static_cast<std::size_t>(place.page) >= tiles.size()) tiles.emplace_back();
    tiles.back() += tile(marker, place.x, place.y);
    sheet.markers.push_back({marker.id,
                             place.page,
                             (place.x + 0.5 * paper) * kMetresPerMillimetre,
                             (place.y + 0.5 * paper) * kMetresPerMillimetre});
  }
  if (tiles.empty()) {
    throw InputError(
        fmt::format("{}: has no marker to print, must have a [[marker]] of a kind other "
                    "than patch",
                    name));
  }
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    sheet.pages.push_back(
        page(rig.name, static_cast<int>(i) + 1, static_cast<int>(tiles.size()), tiles[i]));
  }
  return sheet;
}

}  // namespace twang
