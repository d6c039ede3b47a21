/* MuJoCo: the parts of its position stage that a centre of mass takes. */
#include <mujoco/mujoco.h>

#include <string.h>

#include "peers.h"
#include "robot.h"

static mjModel *model;
static mjData *data;
/* The support is the one child of the world. */
static const int support = 1;

/* NULL, or what went wrong. */
PEER const char *mujoco_open(const char *urdf)
{
    static char error[1000];
    model = mj_loadXML(urdf, NULL, error, sizeof error);
    if (!model)
        return error;
    data = mj_makeData(model);
    if (model->nq != ROBOT_DOF)
        return "MuJoCo counts other joints";
    for (int j = 0; j < ROBOT_DOF; ++j)
        if (strcmp(mj_id2name(model, mjOBJ_JOINT, j), robot_joint[j]) != 0)
            return "MuJoCo orders the joints differently";
    return NULL;
}

PEER void mujoco_com(const double *q, double *out)
{
    memcpy(data->qpos, q, sizeof(double) * ROBOT_DOF);
    mj_kinematics(model, data);
    mj_comPos(model, data);
    memcpy(out, data->subtree_com + 3 * support, sizeof(double) * 3);
}

PEER void mujoco_com_batch(const double *q, size_t n, double *out)
{
    for (size_t k = 0; k < n; ++k)
        mujoco_com(q + ROBOT_DOF * k, out + 3 * k);
}

/* Rows of 20, as MuJoCo has them. */
PEER void mujoco_jacobian(const double *q, double *out)
{
    memcpy(data->qpos, q, sizeof(double) * ROBOT_DOF);
    mj_kinematics(model, data);
    mj_comPos(model, data);
    mj_jacSubtreeCom(model, data, out, support);
}

PEER void mujoco_jacobian_batch(const double *q, size_t n, double *out)
{
    for (size_t k = 0; k < n; ++k)
        mujoco_jacobian(q + ROBOT_DOF * k, out + JACOBIAN * k);
}
