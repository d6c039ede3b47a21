// Pinocchio as its users call it, and the least squares of Eigen.
//
// Pinocchio leaves the mass of the support out of its centre of mass; it is added
// at the cost of three multiplications and additions.

#include <pinocchio/algorithm/center-of-mass.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/regressor.hpp>
#include <pinocchio/multibody.hpp>

#include <Eigen/Cholesky>

#include "peers.h"
#include "robot.h"

static_assert(ROBOT_DOF == 20, "peers.h states the sizes of the OP2");

namespace pin = pinocchio;

static pin::Model model_of_robot()
{
    pin::Model model;
    typedef Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> Rotation;
    typedef Eigen::Map<const Eigen::Vector3d> Vector;
    for (int j = 0; j < ROBOT_DOF; ++j) {
        const pin::SE3 placement(Rotation(robot_rotation + 9 * j), Vector(robot_translation + 3 * j));
        // The specialised joints, the fastest there are.
        pin::JointModel joint = pin::JointModelRZ();
        if (robot_axis[j] == 0)
            joint = pin::JointModelRX();
        if (robot_axis[j] == 1)
            joint = pin::JointModelRY();
        const auto id = model.addJoint(robot_parent[j], joint, placement, robot_joint[j]);
        const pin::Inertia inertia(robot_mass[j + 1], Vector(robot_centre + 3 * (j + 1)),
                                   pin::Symmetric3::Identity());
        model.appendBodyToJoint(id, inertia, pin::SE3::Identity());
    }
    return model;
}

template <typename Scalar>
struct Robot {
    typedef pin::ModelTpl<Scalar> Model;
    typedef Eigen::Matrix<Scalar, 3, 1> Vector;
    typedef Eigen::Matrix<Scalar, ROBOT_DOF, 1> Posture;

    Model model;
    pin::DataTpl<Scalar> data;
    Posture q;
    Vector support;
    Scalar share;

    Robot() : model(model_of_robot().cast<Scalar>()), data(model)
    {
        double total = 0;
        for (double mass : robot_mass)
            total += mass;
        share = Scalar((total - robot_mass[0]) / total);
        support = (Eigen::Map<const Eigen::Vector3d>(robot_centre) * (robot_mass[0] / total)).cast<Scalar>();
    }

    const Posture &posture(const Scalar *from)
    {
        q = Eigen::Map<const Posture>(from);
        return q;
    }

    void com(const Scalar *from, Scalar *out)
    {
        Eigen::Map<Vector>(out).noalias() =
            support + share * pin::centerOfMass(model, data, posture(from), false);
    }

    void jacobian(const Scalar *from, Scalar *out)
    {
        Eigen::Map<Eigen::Matrix<Scalar, 3, ROBOT_DOF>>(out).noalias() =
            share * pin::jacobianCenterOfMass(model, data, posture(from), false);
    }

    void full(const Scalar *from, Scalar *out)
    {
        pin::forwardKinematics(model, data, posture(from));
        for (int j = 0; j < ROBOT_DOF; ++j)
            Eigen::Map<Eigen::Matrix<Scalar, 3, 3>>(out + 9 * j) = data.oMi[j + 1].rotation();
    }

    // Its own regressor, of masses and first moments: 3 × 80.
    void standard(const Scalar *from, Scalar *out)
    {
        Eigen::Map<Eigen::Matrix<Scalar, 3, 4 * ROBOT_DOF>> to(out);
        to = pin::computeStaticRegressor(model, data, posture(from));
    }

    void cop(const Scalar *from, Scalar *out)
    {
        pin::forwardKinematics(model, data, posture(from));
        out[0] = out[3] = 1;
        out[1] = out[2] = 0;
        for (int j = 0; j < ROBOT_DOF; ++j) {
            const auto &turn = data.oMi[j + 1].rotation();
            const int a = robot_axis[j] == 0, b = robot_axis[j] == 2 ? 1 : 2;
            Scalar *to = out + 4 + 4 * j;
            to[0] = turn(0, a);
            to[1] = turn(1, a);
            to[2] = turn(0, b);
            to[3] = turn(1, b);
        }
    }
};

static Robot<double> f64;
static Robot<float> f32;

PEER const char *peer_joint(int joint) { return robot_joint[joint]; }
PEER const double *robot_full(void) { return robot_full_params; }
PEER const double *robot_base(void) { return robot_base_params; }

#define OFFER(NAME, SIZE)                                                                        \
    PEER void pinocchio_##NAME(const double *q, double *out) { f64.NAME(q, out); }               \
    PEER void pinocchio_##NAME##_batch(const double *q, size_t n, double *out)                   \
    {                                                                                            \
        for (size_t k = 0; k < n; ++k)                                                           \
            f64.NAME(q + ROBOT_DOF * k, out + SIZE * k);                                         \
    }                                                                                            \
    PEER void pinocchio_##NAME##_batch_f32(const float *q, size_t n, float *out)                 \
    {                                                                                            \
        for (size_t k = 0; k < n; ++k)                                                           \
            f32.NAME(q + ROBOT_DOF * k, out + SIZE * k);                                         \
    }

OFFER(com, COM)
OFFER(jacobian, JACOBIAN)
OFFER(full, FULL)
OFFER(standard, 3 * 80)
OFFER(cop, COP)

// What the columns of its own regressor say, to be compared.
PEER void pinocchio_com_of_standard(const double *columns, double *com)
{
    Eigen::Matrix<double, 4 * ROBOT_DOF, 1> params;
    for (int j = 0; j < ROBOT_DOF; ++j)
        params.segment<4>(4 * j) = f64.model.inertias[j + 1].toDynamicParameters().head<4>();
    Eigen::Map<Eigen::Vector3d> to(com);
    to = f64.support
        + f64.share * (Eigen::Map<const Eigen::Matrix<double, 3, 4 * ROBOT_DOF>>(columns) * params);
}

// Normal equations of blocks of postures, then LDLT.
PEER void eigen_fit(peer_rows rows, const double *q, const double *reading, size_t n, double *params)
{
    const size_t block = 512;
    typedef Eigen::Matrix<double, ROBOT_BASE, ROBOT_BASE> Gram;
    typedef Eigen::Matrix<double, ROBOT_BASE, 1> Params;
    static Eigen::Matrix<double, ROBOT_BASE, Eigen::Dynamic> transposed(ROBOT_BASE, 2 * block);
    Gram gram = Gram::Zero();
    Params right = Params::Zero();
    for (size_t start = 0; start < n; start += block) {
        const size_t count = std::min(block, n - start);
        for (size_t k = 0; k < count; ++k) {
            double out[COP];
            rows(q + ROBOT_DOF * (start + k), out);
            transposed.middleCols<2>(2 * k) = Eigen::Map<Eigen::Matrix<double, 2, ROBOT_BASE>>(out).transpose();
        }
        const auto used = transposed.leftCols(2 * count);
        gram.selfadjointView<Eigen::Lower>().rankUpdate(used);
        right.noalias() += used * Eigen::Map<const Eigen::VectorXd>(reading + 2 * start, 2 * count);
    }
    Eigen::Map<Params> out(params);
    out = gram.selfadjointView<Eigen::Lower>().ldlt().solve(right);
}
