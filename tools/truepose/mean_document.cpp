#include "tools/truepose/mean_document.hpp"

#include <boost/json.hpp>

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

}  // namespace truepose::tools
