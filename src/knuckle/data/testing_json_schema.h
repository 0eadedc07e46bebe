// SPDX-License-Identifier: Apache-2.0
// For tests only: holds JSON against the part of JSON Schema (2020-12) that schemas/ use.
#pragma once

#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace knuckle::testing {

/// Says where a value breaks a schema. Throws where the schema uses what is not checked here.
class JsonSchema {
 public:
  explicit JsonSchema(nlohmann::json schema) : root_(std::move(schema)) {}

  /// The first fault, as in "/hands/0/score: is not a number"; empty where there is none.
  std::string fault(const nlohmann::json& value) const { return fault(value, root_, ""); }

 private:
  using Json = nlohmann::json;

  std::string fault(const Json& value, const Json& schema, const std::string& place) const {
    if (schema.is_boolean()) return schema.get<bool>() ? "" : place + ": is not allowed";
    require_known_keywords(schema);
    if (schema.contains("$ref")) {
      const std::string path = schema.at("$ref");
      if (const std::string found = fault(value, root_.at(Json::json_pointer(path.substr(1))), place);
          !found.empty())
        return found;
    }
    if (schema.contains("type") && !has_type(value, schema.at("type")))
      return place + ": is not of the type " + schema.at("type").dump();
    if (schema.contains("enum") && !contains(schema.at("enum"), value))
      return place + ": is not one of the values";
    if (value.is_number() && schema.contains("minimum") && value < schema.at("minimum"))
      return place + ": is below the minimum";
    if (value.is_array()) return fault_of_array(value, schema, place);
    if (value.is_object()) return fault_of_object(value, schema, place);
    return "";
  }

  std::string fault_of_array(const Json& value, const Json& schema, const std::string& place) const {
    if (schema.contains("minItems") && value.size() < schema.at("minItems")) return place + ": is too short";
    if (schema.contains("maxItems") && value.size() > schema.at("maxItems")) return place + ": is too long";
    if (!schema.contains("items")) return "";
    for (std::size_t i = 0; i < value.size(); ++i) {
      std::string found = fault(value[i], schema.at("items"), place + "/" + std::to_string(i));
      if (!found.empty()) return found;
    }
    return "";
  }

  std::string fault_of_object(const Json& value, const Json& schema, const std::string& place) const {
    for (const Json& key : schema.value("required", Json::array())) {
      if (!value.contains(key.get<std::string>())) return place + ": lacks " + key.dump();
    }
    for (const auto& [key, entry] : value.items()) {
      const std::string inside = place + "/" + key;
      std::string found;
      if (schema.contains("propertyNames")) found = fault(key, schema.at("propertyNames"), inside);
      if (found.empty() && schema.contains("properties") && schema.at("properties").contains(key)) {
        found = fault(entry, schema.at("properties").at(key), inside);
      } else if (found.empty() && schema.contains("additionalProperties")) {
        found = fault(entry, schema.at("additionalProperties"), inside);
      }
      if (!found.empty()) return found;
    }
    return "";
  }

  static bool contains(const Json& list, const Json& value) {
    for (const Json& entry : list) {
      if (entry == value) return true;
    }
    return false;
  }

  static bool has_type(const Json& value, const Json& type) {
    if (type.is_array()) {
      for (const Json& one : type) {
        if (has_type(value, one)) return true;
      }
      return false;
    }
    if (type == "integer") return value.is_number_integer();
    return type == value.type_name();
  }

  static void require_known_keywords(const Json& schema) {
    static const std::set<std::string> known{
        "$schema",  "$defs",      "$ref",     "title",   "description",   "type",
        "enum",     "properties", "required", "minimum", "propertyNames", "additionalProperties",
        "minItems", "maxItems",   "items"};
    for (const auto& [key, ignored] : schema.items()) {
      if (!known.contains(key)) throw std::logic_error("the schema uses '" + key + "', which is not checked");
    }
  }

  Json root_;
};

}  // namespace knuckle::testing
