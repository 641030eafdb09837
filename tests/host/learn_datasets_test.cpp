// Learn on five sets of other people's data, held-out figures as medians over ten splits; calibration.md §6.
// Expected figures and the peers' own stand in host/LEARN.md.
#include <set>
#include <tuple>

#include "host/cross_validation.hpp"
#include "host/stream_alignment.hpp"
#include "tests/host/learn_data.hpp"
#include "tools/convert/text_files.hpp"

namespace armsight::host {
namespace {

const BlocksTried& candidate(const DatasetCalibration& result, const std::string& name) {
  for (const auto& c : result.choice.tried) {
    if (name_of(c.blocks) == name) return c;
  }
  throw std::out_of_range(name);
}

void print_all(const DatasetCalibration& result) {
  for (const auto& c : result.choice.tried) {
    std::printf(
        "%-18s %s training rms %.3f mm mean %.3f median %.3f | held-out rms %.3f mm %.3f deg, median %.3f mm %.3f deg, "
        "%.3f px\n",
        name_of(c.blocks).c_str(), &c == &result.chosen() ? "*" : " ", c.training.rms_mm, c.training.mean_mm,
        c.training.median_mm, c.heldout.rms_mm, c.heldout.rms_deg, c.heldout.median_mm, c.heldout.median_deg,
        c.heldout.rms_px);
  }
  for (const auto& row : result.left_out) std::printf("  left out %s: %s\n", row.label.c_str(), row.reason.c_str());
  for (const auto& sentence : result.unobservable) std::printf("  %s\n", sentence.c_str());
}

DatasetCalibration learn_set(const std::string& kind, const std::string& set, Dataset* out = nullptr, int seeds = 10) {
  const test::ScratchFolder folder;
  tools::convert(kind, test::data_folder() / set, folder.path());
  const Dataset dataset = load_dataset(folder.path());
  const DatasetCalibration result = calibrate_dataset(dataset, {LearnCost::kLikelihood, seeds, 0.02});
  print_all(result);
  if (out) *out = dataset;
  return result;
}

TEST(LearnOnData, TalosNeedsItsLinksCorrectedAndHasExactlyThreeGauges) {
  ARMSIGHT_NEED_DATA("talos-pyrene-apriltag");
  Dataset dataset;
  const DatasetCalibration result = learn_set("talos", "talos-pyrene-apriltag", &dataset);
  EXPECT_EQ(dataset.rows, 96);
  EXPECT_NE(name_of(result.chosen().blocks).find("links"), std::string::npos);
  EXPECT_LE(result.chosen().heldout.median_mm, 7.0);
  EXPECT_LE(result.chosen().heldout.median_deg, 1.5);
  EXPECT_LT(candidate(result, "+ offsets").heldout.median_deg, candidate(result, "mounts only").heldout.median_deg);
  EXPECT_EQ(result.parameters, 34);
  EXPECT_EQ(result.rank, 31);
  ASSERT_EQ(result.unobservable.size(), 3u);
  std::string all;
  for (const auto& sentence : result.unobservable) all += sentence + "\n";
  for (const char* joint : {"arm_left_7_joint is held", "arm_right_7_joint is held", "head_2_joint is held"}) {
    EXPECT_NE(all.find(joint), std::string::npos) << all;
  }
  bool names_the_gross_one = false;
  for (const auto& row : result.left_out) names_the_gross_one |= row.reason.find("134") != std::string::npos;
  EXPECT_TRUE(names_the_gross_one);
  EXPECT_LE(result.left_out.size(), 10u);
}

TEST(LearnOnData, TalosSimulatedTruthIsFound) {
  ARMSIGHT_NEED_DATA("talos-pyrene-apriltag");
  const test::ScratchFolder folder;
  const int rows = tools::convert_talos(test::data_folder() / "talos-pyrene-apriltag",
                                        "measurements-offset-arm_left_1.csv", folder.path());
  EXPECT_EQ(rows, 85);
  const Dataset dataset = load_dataset(folder.path());
  const DatasetCalibration result = learn_blocks(dataset, {ModelBlock::kOffsets});
  print_all(result);
  for (const auto& offset : result.solution.model.offsets) {
    const bool is_injected = offset.name == "arm_left_1_joint";
    EXPECT_NEAR(offset.value / kDegree, is_injected ? -1.432 : 0.0, 0.3) << offset.name;
    if (offset.value != 0.0) std::printf("  %s %.3f deg\n", offset.name.c_str(), offset.value / kDegree);
  }
}

TEST(LearnOnData, RctNeedsNoOffsetsWhereThePeerClaimsThem) {
  ARMSIGHT_NEED_DATA("rct-two-axis-positioner");
  Dataset dataset;
  const DatasetCalibration result = learn_set("rct", "rct-two-axis-positioner", &dataset);
  EXPECT_EQ(dataset.rows, 205);
  EXPECT_LE(result.choice.tried[0].training.mean_mm, 0.42);
  EXPECT_LE(result.choice.tried[0].heldout.rms_mm, 0.475);
  for (const auto& c : result.choice.tried) {  // the peer: "54 % better"
    EXPECT_GT(c.heldout.rms_mm, 0.85 * result.choice.tried[0].heldout.rms_mm) << name_of(c.blocks);
    EXPECT_EQ(name_of(c.blocks).find("offsets"), std::string::npos);
  }
}

TEST(LearnOnData, RctIsSolvedFromThePeersGuessAndFromTheIdentityAlone) {
  ARMSIGHT_NEED_DATA("rct-two-axis-positioner");
  const test::ScratchFolder folder;
  tools::convert("rct", test::data_folder() / "rct-two-axis-positioner", folder.path());
  Dataset dataset = load_dataset(folder.path());
  BatchOptions options;
  options.noise = dataset.noise;
  options.max_iterations = 200;
  const auto peer = solve_batch({dataset.model}, dataset.observations, options);  // no closed form to help
  EXPECT_LE(evaluate(peer.model, dataset.observations, options.noise).mean_mm, 0.42);
  dataset.model.T_C_a.value = {};
  dataset.model.targets[0].T_b_M.value = {};
  const auto identity = solve_batch({dataset.model}, dataset.observations, options);
  EXPECT_LE(evaluate(identity.model, dataset.observations, options.noise).mean_mm, 0.42);
  const auto both = learn(dataset.model, dataset.observations, options);
  EXPECT_LE(evaluate(both.model, dataset.observations, options.noise).mean_mm, 0.42);
}

TEST(LearnOnData, Ur10eNeedsItsLinksCorrectedAndDoesNotTakeOffsetsForThem) {
  ARMSIGHT_NEED_DATA("ur10e-chessboard");
  Dataset dataset;
  const DatasetCalibration result = learn_set("ur10e", "ur10e-chessboard", &dataset, 3);
  EXPECT_EQ(dataset.rows, 23);
  EXPECT_EQ(dataset.observations.size(), 23u);
  const auto& mounts = candidate(result, "mounts only");
  EXPECT_LE(mounts.training.rms_px, 4.66);  // the reference's own
  EXPECT_LE(mounts.heldout.rms_px, 5.72);
  EXPECT_GT(candidate(result, "+ offsets").heldout.rms_px, 0.9 * mounts.heldout.rms_px);
  EXPECT_NE(name_of(result.chosen().blocks).find("links"), std::string::npos);
  EXPECT_LE(result.chosen().heldout.rms_px, 2.2);
}

TEST(LearnOnData, CamodocalOutliersAreNamedAndDoNoHarm) {
  ARMSIGHT_NEED_DATA("camodocal-arm-artag");
  Dataset dataset;
  const DatasetCalibration result = learn_set("camodocal", "camodocal-arm-artag", &dataset);
  EXPECT_EQ(dataset.rows, 42);
  EXPECT_LE(result.choice.tried[0].heldout.rms_mm, 6.0);
  EXPECT_LE(result.choice.tried[0].training.median_mm, 3.0);
  EXPECT_GE(result.left_out.size(), 1u);
  EXPECT_LE(result.left_out.size(), 8u);
  EXPECT_NE(result.left_out[0].reason.find("times the median"), std::string::npos);
}

TEST(LearnOnData, EthzClocksAreAligned) {
  ARMSIGHT_NEED_DATA("ethz-arm-sim");
  Dataset dataset;
  const DatasetCalibration result = learn_set("ethz", "ethz-arm-sim", &dataset, 1);
  ASSERT_TRUE(result.time_offset_s.has_value());
  std::printf("offset %.4f s, %zu looks\n", *result.time_offset_s, result.looks.size());
  EXPECT_LE(std::abs(*result.time_offset_s), 0.005);  // "clocks agree"
  EXPECT_LE(result.choice.tried[0].training.median_mm, 1.0);
  EXPECT_LE(result.choice.tried[0].heldout.median_mm, 1.0);
  EXPECT_GT(result.time_offset_sigma_s, 2e-5);
  EXPECT_LT(result.time_offset_sigma_s, 5e-4);
  const auto all = evaluate(result.solution.model, looks_at_offset(dataset, *result.time_offset_s, nullptr),
                            result.solution.noise);
  EXPECT_LE(all.median_mm, 1.0);
  EXPECT_LE(all.median_deg, 0.12);

  BatchOptions options;
  options.noise = dataset.noise;
  options.estimates_noise = true;
  dataset = without_repeats(dataset);
  for (double& time_s : dataset.look_time_s) time_s -= 0.0373;  // a camera clock that is behind by this
  const double found_s = estimate_time_offset(dataset, options).offset_s;
  EXPECT_NEAR(found_s - *result.time_offset_s, 0.0373, 5.0 * result.time_offset_sigma_s);
}

/// Every number of the source stands in the output as it was written, in order of its row.
void expect_all_numbers(const std::filesystem::path& source, const std::filesystem::path& csv, std::size_t skip_lines,
                        std::size_t skip_fields) {
  const auto in = tools::read_lines(source), out = tools::read_lines(csv);
  ASSERT_EQ(in.size() - skip_lines, out.size() - 1);
  for (std::size_t i = 0; i + skip_lines < in.size(); ++i) {
    auto wanted = tools::split(in[i + skip_lines], ',');
    wanted.erase(wanted.begin(), wanted.begin() + static_cast<std::ptrdiff_t>(skip_fields));
    auto written = tools::split(out[i + 1], ',');
    std::erase(written, "target");
    EXPECT_EQ(wanted, written) << i;
  }
}

TEST(Converters, KeepEveryRowAndEveryDigit) {
  ARMSIGHT_NEED_DATA("talos-pyrene-apriltag");
  ARMSIGHT_NEED_DATA("ethz-arm-sim");
  const test::ScratchFolder folder;
  const auto talos = test::data_folder() / "talos-pyrene-apriltag";
  for (const auto& [csv, rows] : {std::pair{"measurements-pyrene-20200819-1.csv", 96},
                                  {"measurements-pyrene-20200828.csv", 18},
                                  {"measures-simulation.csv", 89},
                                  {"measurements-offset-arm_left_1.csv", 85}}) {
    EXPECT_EQ(tools::convert_talos(talos, csv, folder.path() / "talos"), rows);
    expect_all_numbers(talos / csv, folder.path() / "talos" / "samples.csv", 1, 1);
    EXPECT_EQ(load_dataset(folder.path() / "talos").rows, rows);
  }
  const auto ethz = test::data_folder() / "ethz-arm-sim";
  tools::convert_ethz(ethz, folder.path() / "ethz");
  expect_all_numbers(ethz / "robot_arm_sim_hand.csv", folder.path() / "ethz" / "arm.csv", 0, 0);
  expect_all_numbers(ethz / "robot_arm_sim_camera.csv", folder.path() / "ethz" / "looks.csv", 0, 0);
}

TEST(Converters, KeepEveryNumberOfYamlSources) {
  ARMSIGHT_NEED_DATA("rct-two-axis-positioner");
  ARMSIGHT_NEED_DATA("camodocal-arm-artag");
  ARMSIGHT_NEED_DATA("ur10e-chessboard");
  const test::ScratchFolder folder;
  for (const auto& [kind, set, file, rows] :
       {std::tuple{"rct", "rct-two-axis-positioner", "positioner_kinematic_measurements.yaml", 205},
        std::tuple{"camodocal", "camodocal-arm-artag", "TransformPairsInput.yml", 42},
        std::tuple{"ur10e", "ur10e-chessboard", "configuration_7", 23}}) {
    EXPECT_EQ(tools::convert(kind, test::data_folder() / set, folder.path() / kind), rows);
    std::multiset<std::string> written;
    for (const auto& line : tools::read_lines(folder.path() / kind / "samples.csv")) {
      for (const auto& field : tools::split(line, ',')) written.insert(field);
    }
    std::string text;
    for (const auto& line : tools::read_lines(test::data_folder() / set / file)) text += line + " ";
    for (char& c : text) c = std::string("[],:'").find(c) != std::string::npos ? ' ' : c;
    for (const auto& word : tools::split(text, ' ')) {
      const bool is_number =
          word.find('.') != std::string::npos && word.find_first_not_of("0123456789.e+-") == std::string::npos;
      const bool is_header = word == "0." || word == "1." || word == "1.0";  // last matrix row, "%YAML:1.0"
      if (!is_number || is_header) continue;
      EXPECT_EQ(written.count(word) > 0, true) << kind << " " << word;
    }
  }
}

TEST(Converters, RefuseWhatIsNotTheSetAndSayWhere) {
  const test::ScratchFolder folder;
  tools::write_file(folder.path() / "robot_arm_sim_hand.csv", "1,2,3,4,5,6,7,8\n1,2,x,4,5,6,7,8\n");
  try {
    tools::convert_ethz(folder.path(), folder.path() / "out");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("robot_arm_sim_hand.csv:2:1: 'x' must be a finite number"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace armsight::host
