"""The token's way into a browser: the printed address keeps it in a cookie."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query
from fastapi.responses import RedirectResponse, Response

from ..request_guard import COOKIE, LOGIN
from ..tokens import Tokens
from .errors import HTTPProblem
from .state import ConsoleState

router = APIRouter(include_in_schema=False)


@router.get(LOGIN)
async def login(
    state: ConsoleState, shown: Annotated[str, Query(alias="token", max_length=500)] = ""
) -> Response:
    """The printed address: keeps the token in a cookie that no script and no other page gets,
    and goes on to the page.
    """
    tokens = Tokens(state.settings.token, state.settings.viewer_token)
    if tokens.role_of(shown) is None:
        raise HTTPProblem(401, "this is not the token")
    answer = RedirectResponse("./", 303)
    # without a path it is that of this page: what else a proxy shows at its name does not get it
    answer.set_cookie(COOKIE, shown, httponly=True, samesite="strict", path=None)
    return answer
