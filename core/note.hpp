// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace twang {

/// Whether a sentence merely says how it was, or what may make the result wrong.
enum class Severity { Remark, Warning };

/// One sentence for a person, with the weight that whoever wrote it gave it. A bare text is a
/// remark.
struct Note {
  Note(std::string sentence, Severity weight = Severity::Remark)
      : text(std::move(sentence)), severity(weight) {}

  std::string text;
  Severity severity;
};

/// The sentences of one weight, in their order.
[[nodiscard]] inline std::vector<std::string> sentences_of(const std::vector<Note>& notes,
                                                           Severity severity) {
  std::vector<std::string> sentences;
  for (const Note& note : notes) {
    if (note.severity == severity) sentences.push_back(note.text);
  }
  return sentences;
}

}  // namespace twang
