#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace truepose::rsi {

/// How a version of RSI keeps a signal flow: RSI 3 (KSS 8.3 and 8.4) in NAME.rsi.xml, RSI 4.0 (KSS 8.5) in a
/// NAME.rsix of its own, RSI 4.1 and 5 (KSS 8.6 and 8.7) in NAME.rsix, and RSI 6 (iiQKA.OS2) in the same.
enum class ContextFormat { RsiXml, Rsix40, Rsix, Rsix6 };

/// An input or output of a kind of object.
struct CataloguePort {
  std::string name;
  int copies = 1;  ///< at most so many of it, where an object has as many as are wired
};

struct CatalogueParameter {
  std::string name;
  int ordinal = 0;                  ///< in files of the format
  std::vector<std::string> values;  ///< of an enumeration, in the order of their numbers; else none
  std::string otherwise;            ///< what it is where a file does not give it
  bool fixed =
      false;  ///< cannot be changed while RSI runs; such parameters are counted apart from the others
};

/// A kind of object, as one format has it.
struct CatalogueObject {
  std::string type;  ///< in capitals, the same in all formats: "AXISCORR"
  std::string name;  ///< in files of the format: "AxisCorr"
  int id = 0;        ///< RSI 3 has kinds that share one
  int first = 0;     ///< ordinal of the first input and output
  std::vector<CataloguePort> inputs, outputs;
  std::vector<CatalogueParameter> parameters;  ///< those whose ordinals are known

  /// Null where it has none of that name.
  const CatalogueParameter* parameter(std::string_view name) const;
};

/// The kinds of objects that RSIVisual offers for a format; for RSI 3 those that published contexts have.
/// What the writer of contexts, their lint and the simulated controller know of objects, they know from here.
///
/// Source: objects.tsv, which names its own.
const std::vector<CatalogueObject>& object_catalogue(ContextFormat format);

/// By its type in any letter case; null where the format has none.
const CatalogueObject* catalogued(std::string_view type, ContextFormat format = ContextFormat::Rsix);

/// The number of a value of an enumeration, as Type "Mode_Op" of STATUS; -1 where there is none.
int number_of(std::string_view type, std::string_view parameter, std::string_view value);

/// What a numeric parameter is where a file does not give it; 0 where it has no number.
double otherwise(std::string_view type, std::string_view parameter);

}  // namespace truepose::rsi
