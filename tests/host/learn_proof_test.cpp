// The proof on other people's data, one fold seed: every bar holds, the file is what programs expect of it, and a set
// that is not there is said to be so.
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/host/learn_data.hpp"
#include "tools/proof/proof.hpp"

namespace armsight::tools {
namespace {

class Proof : public testing::TestWithParam<const char*> {};

TEST_P(Proof, EveryBarHoldsWithOneFoldSeed) {
  ARMSIGHT_NEED_DATA(GetParam());
  std::ostringstream told;
  const auto rows = prove_set(GetParam(), {test::data_folder(), 1}, told);
  EXPECT_GE(rows.size(), 2u);
  for (const auto& row : rows) EXPECT_TRUE(row.holds()) << proof_table({row}, false);
  std::printf("%s%s", told.str().c_str(), proof_table(rows, false).c_str());
}
INSTANTIATE_TEST_SUITE_P(Sets, Proof,
                         testing::Values("talos-pyrene-apriltag", "rct-two-axis-positioner", "ur10e-chessboard",
                                         "camodocal-arm-artag", "ethz-arm-sim"),
                         [](const auto& set) { return std::string(set.param).substr(0, 3); });

TEST(Proof, ASetThatIsNotThereIsARowThatDoesNotHoldAndSaysWhy) {
  const test::ScratchFolder empty;
  std::ostringstream told;
  const auto rows = prove_set("camodocal-arm-artag", {empty.path(), 1}, told);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_FALSE(rows[0].holds());
  const auto json = nlohmann::json::parse(proof_json(rows));
  EXPECT_FALSE(json[0]["holds"].get<bool>());
  EXPECT_NE(json[0]["why"].get<std::string>().find("TransformPairsInput.yml"), std::string::npos) << json;
}

TEST(Proof, JudgesEachKindOfBar) {
  ProofRow row{"set", "figure", "mm", 2.0, 3.0, "peer", 2.5, false, false, {}};
  EXPECT_TRUE(row.holds());
  row.is_least = true;
  EXPECT_FALSE(row.holds());
  row.is_least = false;
  row.is_exact = true;
  row.bar = 3.0;
  EXPECT_FALSE(row.holds());
  row.ours = 3.2;
  EXPECT_TRUE(row.holds());
  row.bar.reset();
  EXPECT_TRUE(row.holds());
  row.ours = std::nan("");
  EXPECT_FALSE(row.holds());
  const auto json = nlohmann::json::parse(proof_json({row}));
  for (const char* key : {"dataset", "figure", "unit", "ours", "peer", "peer_name", "bar", "holds"}) {
    EXPECT_TRUE(json[0].contains(key)) << key;
  }
  EXPECT_TRUE(json[0]["bar"].is_null());
}

}  // namespace
}  // namespace armsight::tools
