#include "core/diagnosis/mistake_search.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "core/data/error_bounds.hpp"
#include "core/diagnosis/difference_as_sets.hpp"
#include "core/diagnosis/from_a_row_on.hpp"
#include "core/diagnosis/row_order.hpp"
#include "core/diagnosis/unit_mistakes.hpp"
#include "core/math/parallel.hpp"

namespace truepose {
namespace {

// Of 116 visible pairs all are named with 32, one is not with 24.
constexpr std::size_t kFirstMistakes = 32;   // from which a second one is sought
constexpr std::size_t kBestPairs = 6;        // whose first mistake is then sought again, given the second
constexpr std::size_t kTriedInAnyOrder = 8;  // mistakes: with 4, two of 30 right ones are missed

/// Places of mistakes in the list of all, rising.
using Places = std::vector<std::size_t>;
using Looks = std::map<Places, Look>;

Places with(Places places, std::size_t one_more) {
  places.insert(std::ranges::upper_bound(places, one_more), one_more);
  return places;
}

std::set<Places> least(std::vector<std::pair<double, Places>> ranked, std::size_t most) {
  std::ranges::sort(ranked);
  ranked.resize(std::min(most, ranked.size()));
  std::set<Places> least;
  for (auto& [error_mm, places] : ranked) least.insert(std::move(places));
  return least;
}

/// Those that leave the least, of all that fix what is given.
std::set<Places> most_promising(const Looks& looks, const Places& given, std::size_t most) {
  std::vector<std::pair<double, Places>> ranked;
  for (const auto& [places, look] : looks) {
    if (look.changes && std::ranges::includes(places, given)) ranked.emplace_back(look.rough_mm, places);
  }
  return least(std::move(ranked), most);
}

class MistakeSearch {
 public:
  MistakeSearch(const Diagnosis& diagnosis, const RobotModel& nominal, const MeasurementData& data, int jobs)
      : diagnosis_{diagnosis}, nominal_{nominal}, data_{data}, jobs_{jobs} {
    UnitMistakes units = units_by_magnitude(nominal, data.points);
    add_units(std::move(units.robot));
    add(row_mistakes(nominal));
    add(convention_mistakes());
    add_units(std::move(units.measurements));
    add(column_mistakes(nominal));
    open_ = mistakes_.size();
    add(open_mistakes(nominal));
    add(row_order_mistakes(data.smr_names));
    alone_ = mistakes_.size();
    add(sign_set_mistakes(nominal));
    add(mistakes_from_a_row_on(data.smr_names));
    unordered_ = mistakes_.size();
    add({unordered_rows(data.smr_names)});
  }

  std::vector<Hypothesis> found() const {
    const Looks one = alone();
    auto hypotheses = explaining(one);
    // Any order fits more than any mistake does, and so is thought of where no single one explains the
    // points.
    if (hypotheses.empty()) hypotheses = explaining(look_at({{unordered_}}));
    // Two mistakes at once put an arm far from its points.
    if (!hypotheses.empty() || diagnosis_.as_given().explanation.coarse_mm < kMaxArmError_mm)
      return hypotheses;
    const Looks two = one_more(one, {});
    hypotheses = explaining(two);
    if (hypotheses.empty() && !units_.empty()) hypotheses = explaining(one_more(two, units_));
    if (hypotheses.empty()) hypotheses = explaining(in_any_order());
    return hypotheses;
  }

 private:
  void add(std::vector<Mistake> mistakes) { std::ranges::move(mistakes, std::back_inserter(mistakes_)); }
  void add_units(std::vector<Mistake> mistakes) {
    for (std::size_t k = 0; k < mistakes.size(); ++k) units_.push_back(mistakes_.size() + k);
    add(std::move(mistakes));
  }
  bool is_unit(std::size_t k) const { return std::ranges::binary_search(units_, k); }

  std::vector<Mistake> at(const Places& places) const {
    std::vector<Mistake> mistakes;
    for (const std::size_t k : places) mistakes.push_back(mistakes_[k]);
    return mistakes;
  }

  /// Whether one more mistake is not the same value, set of signs or order of rows twice over.
  bool fits(const Places& places, std::size_t k) const {
    return std::ranges::none_of(places, [&](std::size_t other) {
      const Mistake &a = mistakes_[other], &b = mistakes_[k];
      const bool same_value = a.file == MistakenFile::Robot && a.joint == b.joint && a.key == b.key;
      const bool both_signs = a.key == "sign" && b.key == "sign";
      const bool both_orders = a.needs_all_rows && b.needs_all_rows;
      return other == k || (!is_unit(other) && !is_unit(k) && (same_value || both_signs || both_orders));
    });
  }

  Looks look_at(const std::set<Places>& tries) const {
    std::vector<std::vector<Mistake>> mistakes;
    for (const Places& places : tries) mistakes.push_back(at(places));
    Looks looks;
    auto place = tries.begin();
    for (Look& look : diagnosis_.looks(mistakes)) looks.emplace(*place++, std::move(look));
    return looks;
  }

  std::vector<Hypothesis> explaining(const Looks& looks) const {
    std::vector<Look> seen;
    for (const auto& [places, look] : looks) seen.push_back(look);
    return diagnosis_.explaining(seen);
  }

  Looks alone() const {
    std::set<Places> tries;
    for (std::size_t k = 0; k < unordered_; ++k) tries.insert({k});
    if (!units_.empty()) tries.insert(units_);
    return look_at(tries);
  }

  Looks with_any_other(const std::set<Places>& from) const {
    std::set<Places> tries;
    for (const Places& places : from) {
      for (std::size_t k = 0; k < alone_; ++k) {
        if (places.back() < alone_ && fits(places, k)) tries.insert(with(places, k));
      }
    }
    return look_at(tries);
  }

  /// Pairs, besides what is given: a second mistake given the most promising first ones, then in turns a
  /// first one given the second ones of the best pairs. One that the other hides shows once that is fixed.
  Looks one_more(const Looks& before, const Places& given) const {
    std::set<Places> from = most_promising(before, given, kFirstMistakes);
    if (!units_.empty()) from.insert(units_);
    Looks pairs;
    std::set<Places> done;
    while (!from.empty()) {
      pairs.merge(with_any_other(from));
      done.merge(from);
      from.clear();
      for (const Places& pair : most_promising(pairs, given, kBestPairs)) {
        for (const std::size_t k : pair) {
          const Places one = std::ranges::binary_search(given, k) ? given : with(given, k);
          if (!one.empty() && !done.contains(one)) from.insert(one);
        }
      }
    }
    return pairs;
  }

  /// The mistakes with which joints and points agree best as sets, each with the rows in any order.
  Looks in_any_order() const {
    std::vector<std::pair<double, Places>> ranked(open_);
    parallel_for(static_cast<int>(open_), jobs_, [&](int index) {
      const auto k = static_cast<std::size_t>(index);
      const Places places = is_unit(k) ? units_ : with(units_, k);
      ModelAndPoints fixed{.arm = nominal_, .points = data_.points, .open = {}};
      for (const Mistake& mistake : at(places)) mistake.apply_fix(fixed);
      ranked[k] = {difference_as_sets(fixed.arm, data_.smr_names.size(), fixed.points), places};
    });
    std::set<Places> tries;
    for (const Places& places : least(std::move(ranked), kTriedInAnyOrder))
      tries.insert(with(places, unordered_));
    return look_at(tries);
  }

  const Diagnosis& diagnosis_;
  const RobotModel& nominal_;
  const MeasurementData& data_;
  int jobs_;
  std::vector<Mistake> mistakes_;  ///< in the order of their fixes, that of the rows last
  Places units_;
  // Places where those without a known value begin, those that are tried alone, and any order.
  std::size_t open_, alone_, unordered_;
};

}  // namespace

std::vector<Hypothesis> gross_mistakes(const Diagnosis& diagnosis, const RobotModel& nominal,
                                       const MeasurementData& data, int jobs) {
  return MistakeSearch(diagnosis, nominal, data, jobs).found();
}

}  // namespace truepose
