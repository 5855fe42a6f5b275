/* SPDX-License-Identifier: Apache-2.0 */
#include "button.h"

void button_init(struct button *button, bool level, int64_t now_ns)
{
    *button = (struct button){
        .level = level,
        .level_since_ns = now_ns,
        .pressed = level,
        .pressed_ns = now_ns,
        .told = true,
    };
}

void button_level(struct button *button, bool level, int64_t now_ns)
{
    if (level == button->level)
        return;
    button->level = level;
    button->level_since_ns = now_ns;
}

void button_missed(struct button *button, bool level, int64_t now_ns)
{
    if (level == button->level)
        return;
    if (!level)
        button->told = true;
    button_level(button, level, now_ns);
}

static bool tell(struct button *button, enum ttf_panel_event_kind kind, int64_t at_ns,
                 struct ttf_panel_event *ret)
{
    button->told = true;
    *ret = (struct ttf_panel_event){.kind = kind, .at_ns = at_ns};
    return true;
}

bool button_look(struct button *button, int64_t now_ns, struct ttf_panel_event *ret)
{
    int64_t until_ns = button->level == button->pressed ? now_ns : button->level_since_ns;

    if (button->pressed && !button->told && until_ns - button->pressed_ns >= BUTTON_LONG_NS)
        return tell(button, TTF_PANEL_BUTTON_LONG, button->pressed_ns + BUTTON_LONG_NS, ret);
    if (button->level == button->pressed || now_ns - button->level_since_ns < BUTTON_STEADY_NS)
        return false;
    button->pressed = button->level;
    if (button->pressed) {
        button->pressed_ns = button->level_since_ns;
        button->told = false;
        return false;
    }
    return button->told ? false : tell(button, TTF_PANEL_BUTTON_SHORT, button->level_since_ns, ret);
}

bool button_held(const struct button *button)
{
    return button->level == button->pressed ? button->pressed && !button->told : button->level;
}

int64_t button_next_ns(const struct button *button)
{
    if (button->level != button->pressed)
        return button->level_since_ns + BUTTON_STEADY_NS;
    if (button->pressed && !button->told)
        return button->pressed_ns + BUTTON_LONG_NS;
    return TTF_NS_NEVER;
}
