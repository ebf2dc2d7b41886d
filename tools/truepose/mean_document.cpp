#include "tools/truepose/mean_document.hpp"

#include <boost/json.hpp>
#include <cmath>
#include <cstdint>

namespace truepose::tools {

namespace json = boost::json;

json::value mean_document(const json::array& documents) {
  if (documents[0].is_object()) {
    json::object mean;
    for (const auto& member : documents[0].as_object()) {
      json::array values;
      for (const json::value& document : documents) values.push_back(document.at(member.key()));
      mean[member.key()] = mean_document(values);
    }
    return mean;
  }
  double sum = 0;
  bool all_equal = true;
  for (const json::value& number : documents) {
    sum += number.to_number<double>();
    all_equal = all_equal && number == documents[0];
  }
  // A count that is the same everywhere stays a whole number.
  return all_equal ? documents[0] : json::value(sum / static_cast<double>(documents.size()));
}

json::object spread_document(const json::array& validations, std::string_view over) {
  json::object spread{{"over", over}, {"count", static_cast<std::int64_t>(validations.size())}};
  const auto runs = static_cast<double>(validations.size());
  for (const char* stage : {"before", "geometric", "after"}) {
    json::object deviations;
    for (const char* statistic : {"mean", "max", "rms"}) {
      const auto value = [&](const json::value& run) {
        return run.at(stage).at(statistic).to_number<double>();
      };
      double mean = 0, squares = 0;
      for (const json::value& run : validations) mean += value(run) / runs;
      for (const json::value& run : validations) squares += (value(run) - mean) * (value(run) - mean);
      deviations[statistic] = std::sqrt(squares / (runs - 1));
    }
    spread[stage] = std::move(deviations);
  }
  return spread;
}

}  // namespace truepose::tools
