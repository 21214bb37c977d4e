// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "rigs/rig.hpp"

#include <string>
#include <string_view>

namespace twang {

/// A dictionary of tags: so many tags, told apart by the cells within their black border.
struct MarkerDictionary {
  MarkerKind kind;         ///< ArUco or AprilTag
  std::string_view name;   ///< as its makers write it: "DICT_4X4_50", "tag36h11"
  std::string_view table;  ///< where its codes stand; shorter dictionaries are beginnings of longer
  int num_tags;            ///< tags are numbered from 0
  int num_data_cells;      ///< along a side, without the border
  int correctable_cells;   ///< that may be misread without leaving doubt which tag it is
};

/// The dictionary of that name; capitals do not count, nor whether "DICT_" or "tag" stands before
/// it. AprilTag's families are also known by OpenCV's names ("DICT_APRILTAG_36h11"), for either
/// kind: OpenCV 4 draws them turned by half a turn, which does not move their centres. Null if
/// there is none.
[[nodiscard]] const MarkerDictionary* find_marker_dictionary(MarkerKind kind,
                                                             std::string_view name);

/// All names for a kind, for a person: "tag16h5, tag25h9, ...".
[[nodiscard]] std::string marker_dictionary_names(MarkerKind kind);

/// What a name that is none must be, for a person: "one of ...", and the kind that knows it.
[[nodiscard]] std::string expected_marker_dictionary(MarkerKind kind, std::string_view name);

}  // namespace twang
