#include <gtest/gtest.h>

#include <set>

#include "server/api/openapi.hpp"

#include <nlohmann/json.hpp>

namespace headstock::api {
namespace {

using nlohmann::json;

void collect(const json& value, std::set<std::string>& into) {
  if (value.is_object() && value.contains("$ref")) into.insert(value["$ref"].get<std::string>());
  for (const auto& part : value)
    if (part.is_structured()) collect(part, into);
}

TEST(Schemas, EveryReferenceHasItsSchema) {
  std::set<std::string> references;
  collect(schemas(), references);
  const std::string prefix = "#/components/schemas/";
  for (const auto& reference : references) {
    ASSERT_TRUE(reference.starts_with(prefix)) << reference;
    EXPECT_TRUE(schemas().contains(reference.substr(prefix.size()))) << reference;
  }
}

TEST(Schemas, WhatIsRequiredIsDescribed) {
  for (const auto& [name, schema] : schemas().items())
    for (const auto& field : schema.value("required", json::array()))
      EXPECT_TRUE(schema.at("properties").contains(field)) << name << "." << field;
}

TEST(Description, SaysRoleParametersAndErrorsOfARow) {
  Router router;
  Route route;
  route.method = Method::post;
  route.pattern = "/machines/{id}/commands";
  route.role = Role::operate;
  route.takes = Takes::json;
  route.request = "Command";
  route.response = "MachineAnswer";
  route.errors = {"machine_refused"};
  router.add({route});
  const auto operation = openapi(router, "1").at("paths").at("/machines/{id}/commands").at("post");
  EXPECT_EQ(operation.at("x-role"), "operator");
  EXPECT_EQ(operation.at("parameters").at(0).at("name"), "id");
  for (const char* status : {"200", "400", "401", "403", "404", "409", "413", "415"})
    EXPECT_TRUE(operation.at("responses").contains(status)) << status;
  EXPECT_NE(operation.at("responses").at("409").at("description").get<std::string>().find("machine_refused"), std::string::npos);
}

}  // namespace
}  // namespace headstock::api
