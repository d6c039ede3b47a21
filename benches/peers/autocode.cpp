// Pinocchio's algorithms on CasADi's symbols, written as C.
//
//     autocode FOLDER      writes FOLDER/casadi_f64.c and FOLDER/casadi_f32.c
//
// Of the ways to have a function the one with the fewest instructions is taken.

#include <pinocchio/autodiff/casadi.hpp>

#include <pinocchio/algorithm/center-of-mass.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/multibody.hpp>

#include <algorithm>
#include <iostream>
#include <vector>

#include "robot.h"

namespace pin = pinocchio;
using casadi::DM;
using casadi::Function;
using casadi::Slice;
using casadi::SX;

typedef pin::ModelTpl<SX> Model;
typedef pin::SE3Tpl<SX> Pose;

static Model model_of_robot()
{
    Model model;
    for (int j = 0; j < ROBOT_DOF; ++j) {
        Pose placement;
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column)
                placement.rotation()(row, column) = SX(robot_rotation[9 * j + 3 * row + column]);
            placement.translation()[row] = SX(robot_translation[3 * j + row]);
        }
        pin::JointModelTpl<SX> joint = pin::JointModelRevoluteTpl<SX, 0, 2>();
        if (robot_axis[j] == 0)
            joint = pin::JointModelRevoluteTpl<SX, 0, 0>();
        if (robot_axis[j] == 1)
            joint = pin::JointModelRevoluteTpl<SX, 0, 1>();
        const auto id = model.addJoint(robot_parent[j], joint, placement, robot_joint[j]);
        Pose::Vector3 centre;
        for (int row = 0; row < 3; ++row)
            centre[row] = SX(robot_centre[3 * (j + 1) + row]);
        model.appendBodyToJoint(
            id, pin::InertiaTpl<SX>(SX(robot_mass[j + 1]), centre, pin::Symmetric3Tpl<SX>::Identity()),
            Pose::Identity());
    }
    return model;
}

template <typename Matrix>
static SX symbolic(const Matrix &from)
{
    SX to(from.rows(), from.cols());
    for (Eigen::Index row = 0; row < from.rows(); ++row)
        for (Eigen::Index column = 0; column < from.cols(); ++column)
            to(row, column) = from(row, column);
    return to;
}

static Function best(const std::string &name, const SX &q, const std::vector<SX> &ways)
{
    std::vector<Function> found;
    for (const SX &way : ways)
        for (bool cse : {false, true})
            for (const SX &form : {way, SX::simplify(way)})
                found.push_back(Function(name, {q}, {SX::densify(form)}, casadi::Dict{{"cse", cse}}));
    const auto fewer = [](const Function &a, const Function &b) { return a.n_instructions() < b.n_instructions(); };
    const Function least = *std::min_element(found.begin(), found.end(), fewer);
    std::cout << "  CasADi " << name << ": " << least.n_instructions() << " instructions\n";
    if (least.sz_w() > 1 << 16)
        throw std::runtime_error("a work vector that casadi.c has no room for");
    return least;
}

int main(int count, char **arguments)
{
    if (count != 2) {
        std::cerr << "usage: autocode FOLDER\n";
        return 2;
    }
    const Model model = model_of_robot();
    pin::DataTpl<SX> data(model);
    const SX symbols = SX::sym("q", ROBOT_DOF);
    Eigen::Matrix<SX, Eigen::Dynamic, 1> q(ROBOT_DOF);
    for (int j = 0; j < ROBOT_DOF; ++j)
        q[j] = symbols(j);

    double total = 0;
    for (double mass : robot_mass)
        total += mass;
    const double share = (total - robot_mass[0]) / total;
    SX support(3, 1);
    for (int row = 0; row < 3; ++row)
        support(row) = robot_mass[0] / total * robot_centre[row];

    const SX com = support + share * symbolic(pin::centerOfMass(model, data, q, false));
    const SX jacobian = share * symbolic(pin::jacobianCenterOfMass(model, data, q, false));
    pin::forwardKinematics(model, data, q);
    std::vector<SX> all, seen;
    seen.push_back(SX(DM::eye(2)));
    for (int j = 0; j < ROBOT_DOF; ++j) {
        const SX turn = symbolic(data.oMi[j + 1].rotation());
        all.push_back(turn);
        for (int column = 0; column < 3; ++column)
            if (column != robot_axis[j])
                seen.push_back(turn(Slice(0, 2), column));
    }

    const std::vector<Function> functions = {
        best("casadi_com_raw", symbols, {com}),
        best("casadi_jacobian_raw", symbols, {jacobian, SX::jacobian(com, symbols)}),
        best("casadi_full_raw", symbols, {SX::horzcat(all)}),
        best("casadi_cop_raw", symbols, {SX::horzcat(seen)}),
    };
    for (const std::string scalar : {"double", "float"}) {
        const std::string file = scalar == "double" ? "casadi_f64.c" : "casadi_f32.c";
        casadi::CodeGenerator code(file, casadi::Dict{{"casadi_real", scalar}, {"with_header", false}});
        for (const Function &function : functions)
            code.add(function);
        code.generate(std::string(arguments[1]) + "/");
    }
    return 0;
}
