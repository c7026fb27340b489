#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "remaps/formats/ply_header.h"

/// The walk through the records of a PLY element, for a cursor of binary or of text data.
namespace remaps {

inline constexpr std::array<std::string_view, 3> kPlyAxes = {"x", "y", "z"};

inline const PlyProperty* corner_list(const PlyElement& element) {
  return element.find("vertex_indices", "vertex_index");
}

/// What to do with the next bytes of a record. Neighbouring values that nobody wants are one step.
struct PlyStep {
  enum class Kind { skip, skip_list, coordinate, corners };
  Kind kind;
  PlyType type;              // of the value or of a list's items
  PlyType count_type;        // of a list
  std::uint64_t amount = 0;  // to skip
  std::size_t axis = 0;      // of a coordinate
};

/// The steps through one record. Wanted are the coordinates of 'vertex' and the corners of 'face'
/// and 'tristrips', or nothing.
template <class Cursor>
std::vector<PlyStep> plan_record(const PlyElement& element, bool wanted) {
  using Kind = PlyStep::Kind;
  std::vector<PlyStep> steps;
  for (const PlyProperty& property : element.properties) {
    if (property.count_type) {
      const bool corners = wanted && &property == corner_list(element);
      steps.push_back(
          {corners ? Kind::corners : Kind::skip_list, property.type, *property.count_type});
      continue;
    }
    std::size_t axis = 0;
    while (axis < 3 && &property != element.find(kPlyAxes[axis])) ++axis;
    if (wanted && axis < 3) {
      steps.push_back({Kind::coordinate, property.type, property.type, 0, axis});
      continue;
    }
    if (steps.empty() || steps.back().kind != Kind::skip) {
      steps.push_back({Kind::skip, property.type, property.type});
    }
    steps.back().amount += Cursor::size_in_file(property.type);
  }
  return steps;
}

/// Goes through all records of an element: coordinate(step) and corners(step) are called where the
/// cursor stands before a wanted value or list, end_record() after each record. Before each,
/// run(cursor, n) may take up to n records at once; it returns how many it took.
template <class Cursor, class Handler>
void walk_records(Cursor& cursor, const PlyElement& element, const std::vector<PlyStep>& steps,
                  Handler& handler) {
  for (std::uint64_t record = 0;; ++record) {
    record += handler.run(cursor, element.count - record);
    if (record == element.count) break;
    cursor.place = {&element, record};
    for (const PlyStep& step : steps) {
      switch (step.kind) {
        case PlyStep::Kind::skip:
          cursor.skip(step.amount);
          break;
        case PlyStep::Kind::skip_list: {
          const std::uint64_t n = cursor.integer(step.count_type);
          cursor.expect_list(n, step.type);
          cursor.skip(n * Cursor::size_in_file(step.type));
          break;
        }
        case PlyStep::Kind::coordinate:
          handler.coordinate(cursor, step);
          break;
        case PlyStep::Kind::corners:
          handler.corners(cursor, step);
          break;
      }
    }
    handler.end_record();
  }
}

/// Passes over an element nobody wants.
template <class Cursor>
void skip_element(Cursor& cursor, const PlyElement& element) {
  struct {
    void coordinate(Cursor&, const PlyStep&) {}
    void corners(Cursor&, const PlyStep&) {}
    void end_record() {}
    std::uint64_t run(Cursor&, std::uint64_t) { return 0; }
  } nothing;
  const std::vector<PlyStep> steps = plan_record<Cursor>(element, false);
  cursor.place = {&element, 0};
  if (steps.empty()) return;
  if (steps.size() == 1 && steps[0].kind == PlyStep::Kind::skip) {
    cursor.skip(steps[0].amount * element.count);
  } else {
    walk_records(cursor, element, steps, nothing);
  }
}

}  // namespace remaps
