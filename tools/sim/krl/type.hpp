#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/sim/krl/value.hpp"

namespace truepose::sim::krl {

enum class Kind {
  None,  ///< of a subprogram that returns nothing
  Int,
  Real,
  Bool,
  Char,
  Enumeration,
  Structure,
};

/// A type of KRL. A size of 0 is an array parameter: as long as what is passed.
struct Type {
  Kind kind = Kind::None;
  int id = -1;  ///< of the enumeration or structure
  std::vector<int> sizes = {};

  bool operator==(const Type&) const = default;
  bool is_array() const { return !sizes.empty(); }
  bool is(Kind k) const { return kind == k && !is_array(); }
  bool is_number() const { return is(Kind::Int) || is(Kind::Real); }
  bool is_text() const { return kind == Kind::Char && sizes.size() == 1; }
  /// What SREAD and SWRITE know: a number, BOOL, CHAR or a text.
  bool is_simple() const { return is_number() || is(Kind::Bool) || is(Kind::Char) || is_text(); }
  Type element() const { return {kind, id, {sizes.begin() + 1, sizes.end()}}; }
};

struct Field {
  std::string name;
  Type type;
  bool operator==(const Field&) const = default;
};

struct Structure {
  std::string name;
  std::vector<Field> fields;

  bool operator==(const Structure&) const = default;
  std::optional<int> find(std::string_view field) const;
};

struct Enumeration {
  std::string name;
  std::vector<std::string> literals;

  bool operator==(const Enumeration&) const = default;
  bool has(std::string_view literal) const;
};

/// All types that a program knows.
class Types {
 public:
  /// @pre the name is new
  void add(Structure structure) { structures_.push_back(std::move(structure)); }
  void add(Enumeration enumeration) { enumerations_.push_back(std::move(enumeration)); }
  /// Whether this very type is known.
  bool has(const Structure& structure) const { return std::ranges::count(structures_, structure) > 0; }
  bool has(const Enumeration& enumeration) const {
    return std::ranges::count(enumerations_, enumeration) > 0;
  }

  /// @param name  in capitals
  std::optional<Type> find(std::string_view name) const;
  const Structure& structure(const Type& type) const {
    return structures_[static_cast<std::size_t>(type.id)];
  }
  const Enumeration& enumeration(const Type& type) const {
    return enumerations_[static_cast<std::size_t>(type.id)];
  }
  bool is_structure(const Type& type, std::string_view name) const {
    return type.is(Kind::Structure) && structure(type).name == name;
  }

  /// As KRL writes it: E6AXIS, INT[12].
  std::string name(const Type& type) const;

  /// A variable of that type that never got a value.
  Value blank(const Type& type) const;

  /// How many simple values it holds; no more than `limit` + 1 are counted.
  long size(const Type& type, long limit) const;

 private:
  std::vector<Structure> structures_;
  std::vector<Enumeration> enumerations_;
};

}  // namespace truepose::sim::krl
