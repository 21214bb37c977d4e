// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/marker_dictionary.hpp"

#include <algorithm>
#include <array>
#include <cctype>

namespace twang {
namespace {

constexpr MarkerKind kAruco = MarkerKind::ArUco;
constexpr MarkerKind kApril = MarkerKind::AprilTag;

// Correctable: half of what two codes of the dictionary differ by at least in any turn, but two at
// most. (Of the original ArUco tags some look like others turned.)
constexpr std::array kDictionaries = {
    MarkerDictionary{kAruco, "DICT_4X4_50", "4x4", 50, 4, 1},
    MarkerDictionary{kAruco, "DICT_4X4_100", "4x4", 100, 4, 1},
    MarkerDictionary{kAruco, "DICT_4X4_250", "4x4", 250, 4, 1},
    MarkerDictionary{kAruco, "DICT_4X4_1000", "4x4", 1000, 4, 0},
    MarkerDictionary{kAruco, "DICT_5X5_50", "5x5", 50, 5, 2},
    MarkerDictionary{kAruco, "DICT_5X5_100", "5x5", 100, 5, 2},
    MarkerDictionary{kAruco, "DICT_5X5_250", "5x5", 250, 5, 2},
    MarkerDictionary{kAruco, "DICT_5X5_1000", "5x5", 1000, 5, 2},
    MarkerDictionary{kAruco, "DICT_6X6_50", "6x6", 50, 6, 2},
    MarkerDictionary{kAruco, "DICT_6X6_100", "6x6", 100, 6, 2},
    MarkerDictionary{kAruco, "DICT_6X6_250", "6x6", 250, 6, 2},
    MarkerDictionary{kAruco, "DICT_6X6_1000", "6x6", 1000, 6, 2},
    MarkerDictionary{kAruco, "DICT_7X7_50", "7x7", 50, 7, 2},
    MarkerDictionary{kAruco, "DICT_7X7_100", "7x7", 100, 7, 2},
    MarkerDictionary{kAruco, "DICT_7X7_250", "7x7", 250, 7, 2},
    MarkerDictionary{kAruco, "DICT_7X7_1000", "7x7", 1000, 7, 2},
    MarkerDictionary{kAruco, "DICT_ARUCO_ORIGINAL", "original", 1024, 5, 0},
    MarkerDictionary{kApril, "tag16h5", "tag16h5", 30, 4, 2},
    MarkerDictionary{kApril, "tag25h9", "tag25h9", 35, 5, 2},
    MarkerDictionary{kApril, "tag36h10", "tag36h10", 2320, 6, 2},
    MarkerDictionary{kApril, "tag36h11", "tag36h11", 587, 6, 2},
};

// What OpenCV calls AprilTag's families.
constexpr std::string_view kOpenCvApril = "DICT_APRILTAG_";

/// A name and the kind it is of, without what says only that.
struct PlainName {
  MarkerKind kind;
  std::string text;
};

/// Brings a name into lower case and takes off what stands before it.
PlainName plain(MarkerKind kind, std::string_view name) {
  std::string lower;
  for (const char c : name) {
    lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  const auto take_off = [&lower](std::string_view prefix) {
    const bool there = lower.starts_with(prefix);
    if (there) lower.erase(0, prefix.size());
    return there;
  };
  const bool opencv = take_off("dict_");
  if (take_off("apriltag_")) return {kApril, lower};
  if (kind == kApril && !opencv) take_off("tag");
  return {opencv ? kAruco : kind, lower};
}

const MarkerDictionary* find_plain(const PlainName& wanted) {
  const auto* const found = std::find_if(
      kDictionaries.begin(), kDictionaries.end(), [&](const MarkerDictionary& dictionary) {
        return dictionary.kind == wanted.kind &&
               plain(dictionary.kind, dictionary.name).text == wanted.text;
      });
  return found == kDictionaries.end() ? nullptr : found;
}

}  // namespace

const MarkerDictionary* find_marker_dictionary(MarkerKind kind, std::string_view name) {
  const PlainName wanted = plain(kind, name);
  // AprilTag's families are dictionaries of OpenCV's, whose own are none of AprilTag's.
  if (kind == kApril && wanted.kind == kAruco) return nullptr;
  return find_plain(wanted);
}

std::string marker_dictionary_names(MarkerKind kind) {
  std::string names;
  const auto add = [&names](std::string_view prefix, std::string_view name) {
    if (!names.empty()) names += ", ";
    names += prefix;
    names += name;
  };
  for (const MarkerDictionary& dictionary : kDictionaries) {
    if (dictionary.kind == kind) add("", dictionary.name);
  }
  for (const MarkerDictionary& dictionary : kDictionaries) {
    if (kind == kAruco && dictionary.kind == kApril) {
      add(kOpenCvApril, plain(kApril, dictionary.name).text);
    }
  }
  return names;
}

std::string expected_marker_dictionary(MarkerKind kind, std::string_view name) {
  std::string expected = "one of " + marker_dictionary_names(kind);
  const MarkerKind other = kind == kAruco ? kApril : kAruco;
  if (find_marker_dictionary(other, name) != nullptr) {
    expected += " (it is known to kind = \"";
    expected += to_string(other);
    expected += "\")";
  }
  return expected;
}

}  // namespace twang
