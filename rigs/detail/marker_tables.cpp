// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/text.hpp"
#include "core/units.hpp"
#include "rigs/detail/part_surface.hpp"
#include "rigs/detail/rig_tables.hpp"
#include "rigs/marker_dictionary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

namespace twang::detail {
namespace {

/// A marker that is not on the bench stands within this of the part's surface.
constexpr double kMarkerReach_m = 1e-3;

/// An id is the beginning of a column's name in a trace.
bool usable_as_id(const std::string& id) {
  return std::all_of(id.begin(), id.end(), [](unsigned char c) {
    constexpr unsigned char kLastAscii = 0x7f;
    return std::isalnum(c) || c == '_' || c == '-' || c > kLastAscii;
  });
}

constexpr std::array kMarkerKinds = {MarkerKind::Cross,
                                     MarkerKind::Dot,
                                     MarkerKind::Ring,
                                     MarkerKind::Checker,
                                     MarkerKind::ArUco,
                                     MarkerKind::AprilTag,
                                     MarkerKind::Patch};

void check_on_surface(const TomlTable& table, const Marker& marker, const Rig& rig) {
  const bool has_surface_file =
      std::any_of(rig.parts.begin(), rig.parts.end(), [](const PartSolid& solid) {
        return std::holds_alternative<SurfaceFile>(solid.shape);
      });
  if (marker.fixed || rig.parts.empty() || has_surface_file) return;
  const double outside = detail::distance_to_part(rig.parts, marker.position);
  constexpr double kRounding_m = 1e-9;
  if (outside > kMarkerReach_m + kRounding_m) {
    table.refuse("position_mm",
                 fmt::format("within 1 mm of the part's surface unless fixed = true (it is {} mm "
                             "away from the part)",
                             rounded_text(outside * kMillimetresPerMetre, 3)));
  }
  if (outside <= 0.0 && !detail::reaches_surface(rig.parts, marker.position, kMarkerReach_m)) {
    table.refuse("position_mm",
                 "within 1 mm of the part's surface unless fixed = true (it is deeper inside)");
  }
}

void check_tag(const TomlTable& table, const Marker& marker) {
  const MarkerDictionary* dictionary = find_marker_dictionary(marker.kind, marker.dictionary);
  if (dictionary == nullptr) {
    table.refuse("dictionary", expected_marker_dictionary(marker.kind, marker.dictionary));
  }
  if (marker.tag >= dictionary->num_tags) {
    table.refuse("tag", fmt::format("0 to {} in {}", dictionary->num_tags - 1, dictionary->name));
  }
}

/// Whether two markers would be the same picture: shorter dictionaries are beginnings of longer.
bool same_tag(const Marker& a, const Marker& b) {
  const MarkerDictionary* of_a = find_marker_dictionary(a.kind, a.dictionary);
  const MarkerDictionary* of_b = find_marker_dictionary(b.kind, b.dictionary);
  return of_a != nullptr && of_b != nullptr && of_a->table == of_b->table && a.tag == b.tag;
}

Marker read_marker(const TomlTable& table) {
  std::vector<std::string> kinds;
  for (const MarkerKind kind : kMarkerKinds) kinds.emplace_back(to_string(kind));
  table.allow_only({"id", "kind", "size_mm", "position_mm", "fixed", "dictionary", "tag"});
  Marker marker;
  marker.kind = kMarkerKinds[table.choice("kind", kinds)];
  const bool is_tag = marker.kind == MarkerKind::ArUco || marker.kind == MarkerKind::AprilTag;
  for (const char* key : {"dictionary", "tag"}) {
    if (!is_tag && table.has(key)) table.complain(key, "belongs to aruco and apriltag alone");
  }
  marker.id = table.text("id");
  if (!usable_as_id(marker.id)) table.refuse("id", "made of letters, digits, '_' and '-'");
  marker.size_m = positive_metres(table, "size_mm");
  marker.position = metres(table, "position_mm");
  if (table.has("fixed")) marker.fixed = table.flag("fixed");
  if (is_tag) {
    marker.dictionary = table.text("dictionary");
    marker.tag = table.count("tag");
    check_tag(table, marker);
  }
  return marker;
}

}  // namespace

std::vector<Marker> read_markers(const TomlTable& document, const Rig& rig) {
  std::vector<Marker> markers;
  for (const TomlTable& table : document.tables("marker")) {
    Marker marker = read_marker(table);
    if (std::any_of(markers.begin(), markers.end(), [&](const Marker& other) {
          return other.id == marker.id;
        })) {
      table.refuse("id", "unique, another marker has it");
    }
    const auto twin = std::find_if(markers.begin(), markers.end(), [&](const Marker& other) {
      return same_tag(marker, other);
    });
    if (twin != markers.end()) {
      table.refuse("tag", fmt::format("of one marker alone, '{}' has it too", twin->id));
    }
    check_on_surface(table, marker, rig);
    markers.push_back(std::move(marker));
  }
  return markers;
}

namespace {

void check_known_marker(const TomlTable& table,
                        std::string_view key,
                        const std::string& id,
                        const Rig& rig) {
  if (rig.find_marker(id)) return;
  std::vector<std::string> ids;
  for (const Marker& marker : rig.markers) ids.push_back(marker.id);
  table.refuse(
      key,
      ids.empty()
          ? std::string("the id of a [[marker]], there is none")
          : fmt::format("the id of a [[marker]] (nearest to '{}': {})", id, nearest_word(id, ids)));
}

void read_displacement(const TomlTable& table, const Rig& rig, ObservableDefinition& observable) {
  if (table.has("markers")) {
    table.complain("markers", "belongs to an angle, a displacement has marker = \"a\"");
  }
  observable.kind = ObservableKind::Displacement;
  observable.markers = {table.text("marker")};
  check_known_marker(table, "marker", observable.markers[0], rig);
  if (rig.find_marker(observable.markers[0])->fixed) {
    table.refuse("marker", "a marker that moves, this one is fixed");
  }
  observable.direction = table.direction("direction");
}

void read_angle(const TomlTable& table, const Rig& rig, ObservableDefinition& observable) {
  for (const char* key : {"marker", "direction"}) {
    if (table.has(key))
      table.complain(key, "belongs to a displacement, an angle has markers = [\"a\", \"b\"]");
  }
  observable.kind = ObservableKind::Angle;
  observable.markers = table.texts("markers");
  if (observable.markers.size() != 2 || observable.markers[0] == observable.markers[1]) {
    table.refuse("markers", "the ids of two different markers");
  }
  for (const std::string& id : observable.markers) check_known_marker(table, "markers", id, rig);
  const Marker& a = *rig.find_marker(observable.markers[0]);
  const Marker& b = *rig.find_marker(observable.markers[1]);
  if (a.fixed && b.fixed) table.refuse("markers", "of which one moves, both are fixed");
  const Camera camera = rig.camera.value_or(Camera{});
  const Eigen::Vector3d line = b.position - a.position;
  constexpr double kShortest_m = 1e-6;
  if (std::hypot(camera.image_right.dot(line), camera.image_down.dot(line)) < kShortest_m) {
    table.refuse("markers", "of markers that stand apart in the image, these coincide");
  }
}

}  // namespace

std::optional<ObservableDefinition> read_observable(const TomlTable& document, const Rig& rig) {
  const auto table = document.table("observable");
  if (!table) return std::nullopt;
  table->allow_only({"kind", "marker", "direction", "markers"});
  ObservableDefinition observable;
  if (table->choice("kind", {"displacement", "angle"}) == 0) {
    read_displacement(*table, rig, observable);
  } else {
    read_angle(*table, rig, observable);
  }
  return observable;
}

std::optional<Camera> read_camera(const TomlTable& document, const std::filesystem::path& folder) {
  const auto table = document.table("camera");
  if (!table) return std::nullopt;
  table->allow_only({"capture_fps", "image_right", "image_down", "readout_ms", "lens"});
  Camera camera;
  if (table->has("capture_fps")) camera.capture_fps = table->positive("capture_fps");
  if (table->has("readout_ms")) {
    camera.readout_s = table->non_negative("readout_ms") * kSecondsPerMillisecond;
  }
  if (table->has("lens")) camera.lens = folder / table->text("lens");
  if (table->has("image_right")) camera.image_right = table->direction("image_right").normalized();
  if (table->has("image_down")) camera.image_down = table->direction("image_down").normalized();
  const double cosine = camera.image_right.dot(camera.image_down);
  constexpr double kSkew_rad = 1e-6;
  if (std::abs(cosine) > kSkew_rad) {
    const char* key = table->has("image_down") ? "image_down" : "image_right";
    table->refuse(key,
                  fmt::format("at right angles to {}",
                              table->has("image_down") && table->has("image_right")
                                  ? "image_right"
                                  : "the other image axis, which is left at its default"));
  }
  camera.image_down = (camera.image_down - cosine * camera.image_right).normalized();
  return camera;
}

}  // namespace twang::detail
